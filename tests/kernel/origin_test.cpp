// Positions measured from an origin: the same motion, with the resolution of float32 near the origin.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "dvdx/plan.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"

namespace origin_test {

using namespace dvdx;
using test::Batch;
using test::is_close;
using test::Layout;

constexpr double far = 1e4;  // m

template <class T>
std::vector<T> moved(const Scene& scene, const std::vector<Vec3>& x, const Vec3& v, std::size_t steps) {
  Batch<T> batch(Layout::soa, x.size());
  State<T>& state = batch.view();
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.x[axis][i] = static_cast<T>(x[i][axis]);
      state.v[axis][i] = static_cast<T>(v[axis]);
    }
  }
  const auto plan = compile<T>(scene, {.step = 1.0 / 64}, state);
  REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
  REQUIRE(plan->step(state, steps) == StepResult::done);
  return test::values_of(state);
}

Scene orbit(Anchor anchor, Origin origin) {
  Scene scene;
  scene.add(Spring{.stiffness = 36, .anchor = std::move(anchor)});
  scene.origin = std::move(origin);
  return scene;
}

TEST_CASE_TEMPLATE("origin: an origin for each particle gives a far orbit the bits of the orbit at home", T, float, double) {
  const std::vector<Vec3> anchors{{0, 0, 0}, {far, 0, 0}, {far, -far, 3 * far}};
  const std::vector<Vec3> start(3, Vec3{1, 0.5, 0});
  const auto values = moved<T>(orbit(anchors, anchors), start, {0, 0, 3}, 1000);
  for (std::size_t k = 0; k < 6; ++k) {
    CHECK(values[6 + k] == values[k]);
    CHECK(values[12 + k] == values[k]);
  }
}

TEST_CASE("origin: one anchor for all is the same place seen from each particle's origin") {
  const std::vector<Vec3> origins{{2, 0, 0}, {-3, 1, 0}};
  const auto local = moved<double>(orbit(Vec3{1, 0, 0}, origins), {{0, 0, 0}, {0, 0, 0}}, {0, 1, 0}, 50);
  const auto world = moved<double>(orbit(Vec3{1, 0, 0}, {}), origins, {0, 1, 0}, 50);
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      CHECK(is_close(local[6 * i + axis] + origins[i][axis], world[6 * i + axis], 1e-13));
      CHECK(is_close(local[6 * i + 3 + axis], world[6 * i + 3 + axis], 1e-13));
    }
  }
}

TEST_CASE("origin: surfaces, radial springs, springs of a network and held points move with it") {
  const Vec3 origin{far, 8, -far};
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(RadialSpring{.stiffness = 20.0, .anchor = Vec3{far + 1, 9, -far}, .rest_length = 0.5});
  scene.add(Plane{.normal = {0, 2, 0}, .offset = 7.5, .restitution = 0.5});
  scene.add(Sphere{.center = {far, 8, -far}, .radius = 3, .side = Side::inside, .restitution = 0.9});
  Springs springs;
  springs.pairs = {{0, 1}, {1, 2}};
  springs.stiffness = 50.0;
  Scene joined = scene;
  joined.add(Network(springs));
  joined.add(Constraint(OnPoint{.particle = 0, .at = {far, 8.5, -far}}));
  joined.add(Constraint(OnLine{.particle = 2, .through = {far + 1, 8, -far}, .direction = {0, 1, 0}}));
  const std::vector<Vec3> start{{0, 0.5, 0}, {0.5, 0.25, 0}, {1, 0, 0}};
  for (Scene& each : std::vector<Scene>{scene, joined}) {
    std::vector<Vec3> there = start;
    for (Vec3& x : there) x = {x[0] + origin[0], x[1] + origin[1], x[2] + origin[2]};
    const auto world = moved<double>(each, there, {1, 2, 0}, 60);
    each.origin = origin;
    const auto local = moved<double>(each, start, {1, 2, 0}, 60);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        CHECK(std::abs(local[6 * i + axis] + origin[axis] - world[6 * i + axis]) < 1e-9);
        CHECK(std::abs(local[6 * i + 3 + axis] - world[6 * i + 3 + axis]) < 1e-7);
      }
    }
  }
}

TEST_CASE("origin: wrong origins are refused by name") {
  Batch<float> batch(Layout::soa, 2);
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) batch.view().x[axis][i] = batch.view().v[axis][i] = 0;
  }
  const auto refused = [&](const Scene& scene) {
    const auto plan = compile<float>(scene, {}, batch.view());
    REQUIRE(!plan.has_value());
    return plan.error().message();
  };
  CHECK(refused(orbit(Vec3{}, std::vector<Vec3>{{0, 0, 0}})) == "origin is 1 points: must be one for each of the 2 particles");
  CHECK(refused(orbit(Vec3{}, Vec3{0, std::nan(""), 0})) == "origin[1] is nan: must be a finite number");
  CHECK(refused(orbit(Vec3{}, std::vector<Vec3>{{0, 0, 0}, {0, 0, INFINITY}})).starts_with("origin[1][2] is inf"));
  Scene floor = orbit(Vec3{}, std::vector<Vec3>(2));
  floor.add(Plane{});
  CHECK(refused(floor).starts_with("origin is one for each particle: must be one for all"));
  Scene grains = orbit(Vec3{}, std::vector<Vec3>(2));
  grains.add(Meet{.radius = 0.1});
  CHECK(refused(grains) == "origin is one for each particle: must be one for all in a scene with particles that meet");
  CHECK(!compile<float>(orbit(Vec3{}, std::vector<Vec3>(2)), {}).has_value());
}

}  // namespace origin_test
