// The contact pass: the cost of the search for impacts where there are none, and the cost of impacts.
#include <string>
#include <utility>
#include <variant>

#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"
#include "support/starts.hpp"

namespace dvdx::bench {
namespace {

Scene thrown() {
  Scene scene;
  return scene.add(Constant{.acceleration = {0, -9.81, 0}});
}

// Wind that blows into the corner of a floor and two walls.
Scene corner() {
  Scene scene = fall();
  for (const Vec3& normal : {Vec3{0, 1, 0}, Vec3{-1, 0, 0}, Vec3{0, 0, 1}}) {
    scene.add(Plane{.normal = normal, .restitution = 0.3, .friction = 0.2});
  }
  return scene.add(Constant{.acceleration = {6, 0, -5}});
}

// Starts on the floor, along a wall and in the corner, in turn.
template <class T>
void start_cornered(State<T>& state) {
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) state.x[axis][i] = state.v[axis][i] = 0;
    if (i % 3 != 2) state.x[2][i] = static_cast<T>(1 + i % 7);
    if (i % 3 == 0) state.x[0][i] = static_cast<T>(-1.0 - static_cast<double>(i % 11));
  }
}

// 64 capsules side by side: far from all particles, or so that each meets some in flight.
Scene capsules(double height) {
  Scene scene = fall();
  for (int k = 0; k < 64; ++k) {
    const Vec3 a{0.25 * k - 8, height, -20};
    scene.add(Capsule{.ends = {{a, {a[0], height, 20}}}, .radius = {0.1, 0.1}, .restitution = 0.5});
  }
  return scene;
}

// A distant contact that moves up or around: the cost of moving surfaces that nothing touches.
Scene with_motion(Contact contact, const Vec3& translation, const Vec3& rotation) {
  Scene scene = fall();
  scene.motions = {{.keys = {{.time = 0}, {.time = 1e3, .translation = translation, .rotation = rotation}}}};
  std::visit([](auto& body) { body.motion = 0; }, contact);
  scene.contacts.push_back(std::move(contact));
  return scene;
}

// A mesh among particles, in a grid of 70 x 70 x 70 nodes.
Scene octahedron() {
  TriangleMesh mesh{.vertices = {},
                    .triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}},
                    .restitution = 0.5};
  for (std::size_t k = 0; k < 6; ++k) {
    mesh.vertices.emplace_back();
    mesh.vertices.back()[k / 2] = k % 2 == 0 ? 2 : -2;
  }
  Scene scene = fall();
  return scene.add(std::move(mesh));
}

template <class T>
void add_contacts(Pace pace) {
  const auto in = [](Scene scene, Contact contact) {
    return [scene = with(std::move(scene), std::move(contact))](std::size_t) { return scene; };
  };
  add_everywhere<T>(pace, {.name = "contact/level_plane", .scene = in(fall(), far_floor({0, 1, 0}))});
  add_in_cache<T>(pace, {.name = "contact/oblique_plane", .scene = in(fall(), far_floor({1, 2, 0.5}))});
  add_in_cache<T>(pace, {.name = "contact/sphere", .scene = in(meadow(), far_shell())});
  add_everywhere<T>(pace, {.name = "contact/all_hit", .scene = in(thrown(), floor()), .start = start_hopping<T>});
  for (const std::size_t steps : {std::size_t{1}, std::size_t{16}}) {  // steps a call
    const std::string ends = steps == 1 ? "" : "/steps:" + std::to_string(steps);
    add_in_cache<T>(
        pace, {.name = "contact/resting" + ends, .scene = in(thrown(), ground()), .start = start_resting<T>, .steps = steps});
    add_in_cache<T>(pace, {.name = "contact/corner" + ends,
                           .scene = [](std::size_t) { return corner(); },
                           .start = start_cornered<T>,
                           .steps = steps});
  }
  add_in_cache<T>(pace, {.name = "contact/air_hit", .scene = in(fall(), floor()), .start = start_hopping<T>});
  add_in_cache<T>(pace, {.name = "contact/64_capsules_far", .scene = [](std::size_t) { return capsules(-1e4); }});
  add_in_cache<T>(pace, {.name = "contact/64_capsules_near", .scene = [](std::size_t) { return capsules(0); }});
  add_in_cache<T>(pace, {.name = "contact/moving_plane", .scene = [](std::size_t) {
                           return with_motion(far_floor({0, 1, 0}), {0, 1e3, 0}, {});
                         }});
  add_in_cache<T>(pace, {.name = "contact/moving_sphere", .scene = [](std::size_t) {
                           return with_motion(Sphere{.center = {0, -1e4, 0}, .restitution = 0.5}, {0, 1, 0}, {});
                         }});
  add_in_cache<T>(pace, {.name = "contact/turning_box", .scene = [](std::size_t) {
                           return with_motion(OrientedBox{.center = {0, -1e4, 0}, .restitution = 0.5}, {}, {0, 1e3, 0});
                         }});
  add_in_cache<T>(pace, {.name = "contact/mesh", .scene = [](std::size_t) { return octahedron(); }});
  add_plain<T>(
      pace, "contact/all_hit",
      [](const PlainArrays<T>& arrays) { plain_floor_step(arrays, T(9.81), T(1), static_cast<T>(frame)); }, start_hopping<T>);
}

}  // namespace

void register_contact(Pace pace) {
  add_contacts<float>(pace);
  add_contacts<double>(pace);
}

}  // namespace dvdx::bench
