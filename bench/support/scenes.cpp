#include "support/scenes.hpp"

#include <utility>
#include <vector>

namespace dvdx::bench {
namespace {

constexpr Vec3 gravity{0, -9.81, 0};
constexpr Vec3 wind{3, 0, 1};
constexpr double stiffness = 40, damping = 0.3, drag = 0.02;
constexpr Vec3 anchor{0.5, 1, -0.5};

Spring damped_spring() { return {.stiffness = stiffness, .damping = damping, .anchor = anchor}; }

}  // namespace

Scene fall() {
  Scene scene;
  return scene.add(Constant{.acceleration = gravity}).add(Drag{.coefficient = drag, .wind = wind});
}

Scene meadow() {
  Scene scene = fall();
  return scene.add(damped_spring());
}

Scene gusts() {
  Scene scene = meadow();
  return scene.add(Sinusoid{.acceleration = {1, 0, 0.5}, .angular_frequency = 2});
}

Scene swing() {
  Scene scene;
  return scene.add(Spring{.stiffness = stiffness, .anchor = anchor});
}

Scene stalks() {
  Scene scene = fall();
  return scene.add(Spring{.stiffness = stiffness, .damping = damping, .anchor = at_start});
}

Scene masses(std::size_t count) {
  Scene scene = meadow();
  std::vector<double> each(count);
  for (std::size_t i = 0; i < count; ++i) each[i] = 1 + static_cast<double>(i % 1009) / 1009;
  scene.mass = std::move(each);
  return scene;
}

Scene overdamped() {
  Scene scene;
  return scene.add(Spring{.stiffness = 400, .damping = 40});
}

Scene ring() {
  Scene scene;
  return scene.add(RadialSpring{.stiffness = stiffness, .anchor = Vec3{}, .rest_length = 1.0});
}

Scene with(Scene scene, Contact contact) {
  scene.add(std::move(contact));
  return scene;
}

Plane far_floor(Vec3 normal) { return {.normal = normal, .offset = -1e9, .restitution = 0.5, .friction = 0.3}; }
Plane floor() { return {.normal = {0, 1, 0}, .restitution = 1}; }
Plane ground() { return {.normal = {0, 1, 0}, .restitution = 0, .friction = 0.5}; }
Sphere far_shell() { return {.center = {}, .radius = 1e5, .side = Side::inside, .restitution = 0.5}; }

template <class T>
PlainForces<T> plain_meadow() {
  const auto narrow = [](const Vec3& a) {
    return std::array<T, 3>{static_cast<T>(a[0]), static_cast<T>(a[1]), static_cast<T>(a[2])};
  };
  return {narrow(gravity),           narrow(anchor),          narrow(wind),
          static_cast<T>(stiffness), static_cast<T>(damping), static_cast<T>(drag)};
}

template PlainForces<float> plain_meadow();
template PlainForces<double> plain_meadow();

}  // namespace dvdx::bench
