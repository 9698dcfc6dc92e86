// Names of the last release compile with a warning, and give the bits of the new names.
#include <doctest/doctest.h>

#include <cstdint>
#include <type_traits>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/live.hpp"
#include "dvdx/names.hpp"
#include "dvdx/plan.hpp"

#pragma GCC diagnostic ignored "-Wdeprecated-declarations"

namespace old_names_test {

using namespace dvdx;

template <class Change>
std::uint64_t hash_after(const Change& change) {
  Scene scene;
  scene.add(Gravity{.acceleration = {0, -9.81, 0}});
  scene.add(Collider(Plane{.offset = -1}));
  Soa<double> memory(40);
  State<double> state = memory.view();
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) state.x[axis][i] = state.v[axis][i] = 0.01 * static_cast<double>(i + axis);
  }
  auto plan = compile<double>(scene, {.step = 1.0 / 60});
  REQUIRE(plan.has_value());
  change(*plan);
  REQUIRE(plan->step(state, 40) == StepResult::done);
  return state_hash(state);
}

TEST_CASE("old names: replace is set_force and set_contact") {
  const Constant force{.acceleration = {1, -5, 0}};
  const Plane contact{.offset = -0.5, .restitution = 0.5};
  const auto old_names = hash_after([&](auto& plan) {
    REQUIRE(plan.replace(0, force).has_value());
    REQUIRE(plan.replace(0, contact).has_value());
  });
  const auto new_names = hash_after([&](auto& plan) {
    REQUIRE(plan.set_force(0, force).has_value());
    REQUIRE(plan.set_contact(0, contact).has_value());
  });
  CHECK(old_names == new_names);
  CHECK(old_names != hash_after([](auto&) {}));
}

TEST_CASE("old names: Turnover, LivePlan and Elsewhere are Lifecycle, LifecyclePlan and PartContext") {
  CHECK(std::is_same_v<Turnover, Lifecycle>);
  CHECK(std::is_same_v<LivePlan<float>, LifecyclePlan<float>>);
  CHECK(std::is_same_v<Elsewhere, PartContext>);
}

TEST_CASE("names: Pins, MaxDistance and Tether are Kinematic, Skin and Tethers") {
  CHECK(std::is_same_v<Pins, Kinematic>);
  CHECK(std::is_same_v<MaxDistance, Skin>);
  CHECK(std::is_same_v<Tether, Tethers>);
  CHECK(std::is_same_v<decltype(TriangleMesh::triangles)::value_type, Triangle>);
}

}  // namespace old_names_test
