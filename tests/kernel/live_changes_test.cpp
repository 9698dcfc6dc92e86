// Changes of running plans with particles that come and go.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/live.hpp"

namespace live_changes_test {

using namespace dvdx;

constexpr std::size_t capacity = 600;

template <class T>
struct Sparks {
  Soa<T> memory{capacity}, ages{capacity};
  LiveState<T> live;

  Sparks() {
    const State<T> of_ages = ages.view();
    live = {.state = memory.view(), .age = of_ages.x[0], .lifetime = of_ages.x[1]};
    live.state.count = 0;
  }
};

Emitter nozzle() {
  return {.shape = Vec3{0, 2, 0},
          .rate = 320,
          .velocity = {1, 0, 0},
          .spread = 0.5,
          .least_lifetime = 0.5,
          .most_lifetime = 1,
          .seed = 5};
}

template <class T>
LifecyclePlan<T> plan_of(const Emitter& emitter, double h, const Vec3& g = {0, -9.81, 0},
                         SurvivorOrder order = SurvivorOrder::kept) {
  Scene scene;
  scene.add(Constant{.acceleration = g});
  scene.add(Plane{.restitution = 0.5});
  auto plan = compile<T>(scene, {.emitters = {emitter}, .removal = {.order = order}, .capacity = capacity}, {.step = h});
  REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
  return std::move(*plan);
}

TEST_CASE_TEMPLATE("live changes: another step, force and emitter give the bits of a plan that was compiled with them", T,
                   float, double) {
  for (const SurvivorOrder order : {SurvivorOrder::kept, SurvivorOrder::any}) {
    Sparks<T> one, two;
    LifecyclePlan<T> changed = plan_of<T>(nozzle(), 1.0 / 32, {0, -9.81, 0}, order);
    LifecyclePlan<T> first = plan_of<T>(nozzle(), 1.0 / 32, {0, -9.81, 0}, order);
    REQUIRE(changed.step(one.live, 8) == StepResult::done);
    REQUIRE(first.step(two.live, 8) == StepResult::done);
    Emitter moved = nozzle();
    moved.shape = Vec3{3, 2, 0};
    moved.rate = 640;
    REQUIRE(changed.set_step(1.0 / 64).has_value());
    REQUIRE(changed.set_force(0, Constant{.acceleration = {0, -3, 0}}).has_value());
    REQUIRE(changed.set_emitter(0, moved).has_value());
    REQUIRE(changed.step(one.live, 20) == StepResult::done);
    REQUIRE(plan_of<T>(moved, 1.0 / 64, {0, -3, 0}, order).step(two.live, 20) == StepResult::done);
    CHECK(one.live.born == 80 + 200);
    CHECK(one.live.state.count == two.live.state.count);
    CHECK(state_hash(one.live.state) == state_hash(two.live.state));
    Emitter off = moved;
    off.rate = 0;
    REQUIRE(changed.set_emitter(0, off).has_value());
    REQUIRE(changed.step(one.live, 128) == StepResult::done);
    CHECK(one.live.born == 280);
    CHECK(one.live.state.count == 0);  // all have died of age
  }
}

TEST_CASE("live changes: a burst is so many births at once, which draw numbers of their own") {
  Sparks<double> sparks;
  const LifecyclePlan<double> plan = plan_of<double>(nozzle(), 1.0 / 32);
  REQUIRE(plan.step(sparks.live) == StepResult::done);
  REQUIRE(plan.burst(sparks.live, 0, 100).has_value());
  CHECK(sparks.live.state.count == 110);
  CHECK(sparks.live.born == 110);
  double mean = 0;
  for (std::size_t i = 10; i < 110; ++i) {
    CHECK(sparks.live.age[i] == 0);
    CHECK(sparks.live.state.x[1][i] == 2);
    const Vec3 v{sparks.live.state.v[0][i] - 1, sparks.live.state.v[1][i], sparks.live.state.v[2][i]};
    CHECK(std::hypot(v[0], v[1], v[2]) <= 0.5);
    mean += v[0] / 100;
    CHECK((i == 10 || sparks.live.state.v[0][i] != sparks.live.state.v[0][i - 1]));
  }
  CHECK(std::abs(mean) < 0.1);
  REQUIRE(plan.burst(sparks.live, 0, 1000).has_value());
  CHECK(sparks.live.state.count == capacity);
  CHECK(sparks.live.dropped == 1110 - capacity);
}

TEST_CASE("live changes: a clone steps a state of its own, and keeps what it had") {
  Sparks<float> one, two;
  LifecyclePlan<float> plan = plan_of<float>(nozzle(), 1.0 / 32);
  const LifecyclePlan<float> clone = plan.clone();
  REQUIRE(plan.set_contact(0, Plane{.offset = 1}).has_value());
  REQUIRE(plan.step(one.live, 24) == StepResult::done);
  REQUIRE(clone.step(two.live, 24) == StepResult::done);
  const auto lowest = [](const LiveState<float>& live) {
    float y = 9;
    for (std::size_t i = 0; i < live.state.count; ++i) y = std::min(y, live.state.x[1][i]);
    return y;
  };
  CHECK(lowest(one.live) >= 1 - 1e-6F);
  CHECK(lowest(two.live) < 0.5F);
}

TEST_CASE("live changes: misuse is an error that names what is wrong, and changes nothing") {
  Sparks<float> sparks;
  LifecyclePlan<float> plan = plan_of<float>(nozzle(), 1.0 / 32);
  CHECK(plan.set_step(0).error().field == "step");
  CHECK(plan.set_step(-1).error().field == "step");
  CHECK(plan.set_force(1, Constant{}).error().field == "forces[1]");
  CHECK_FALSE(plan.set_force(0, Spring{.stiffness = std::vector<double>(3, 1.0)}).has_value());
  CHECK(plan.set_contact(1, Plane{}).error().field == "contacts[1]");
  CHECK_FALSE(plan.set_contact(0, Plane{.motion = 0}).has_value());
  CHECK(plan.set_emitter(1, nozzle()).error().field == "emitters[1]");
  CHECK(plan.set_emitter(0, {.rate = -1}).error().field == "emitters[0].rate");
  CHECK(plan.burst(sparks.live, 4, 1).error().field == "emitters[4]");
  CHECK(plan.plan().step_size() == 1.0 / 32);
  sparks.live.state.v[1].base = nullptr;
  CHECK(plan.step(sparks.live) == StepResult::capacity_too_small);
  const LifecyclePlan<float> taken = std::move(plan);
  CHECK(plan.step(sparks.live) == StepResult::moved_from);
  CHECK(plan.set_step(1).error().field == "plan");
  CHECK(plan.burst(sparks.live, 0, 1).error().field == "plan");
}

}  // namespace live_changes_test
