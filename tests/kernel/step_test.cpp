// The promises of a call of step() for every scene.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "free/free_motion.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"
#include "support/scenes.hpp"

namespace step_test {

using namespace dvdx;
using test::Batch;
using test::is_close;
using test::Layout;
using test::NamedScene;

constexpr std::size_t count = 21;

template <class T>
Plan<T> make_plan(const Scene& scene, double step, std::size_t particles = count) {
  Batch<T> batch(Layout::soa, particles);
  test::place(batch.view());
  auto plan = compile<T>(scene, {.step = step}, batch.view());
  REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
  return std::move(*plan);
}

// The start, or the state after some steps.
template <class T>
class Moving {
 public:
  Moving() : batch_(Layout::soa, count) { test::place(batch_.view()); }
  Moving& step(const Plan<T>& plan, std::size_t steps = 1) {
    REQUIRE(plan.step(batch_.view(), steps) == StepResult::done);
    return *this;
  }
  [[nodiscard]] std::vector<T> values() { return test::values_of(batch_.view()); }
  [[nodiscard]] State<T>& state() { return batch_.view(); }

 private:
  Batch<T> batch_;
};

template <class T>
double largest_difference(const std::vector<T>& a, const std::vector<T>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(static_cast<double>(a[i] - b[i])));
  return largest;
}

template <class T>
Scene undamped() {
  Scene scene;
  scene.add(Spring{.stiffness = 30.0, .anchor = Vec3{0.1, -0.2, 0.3}});
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Sinusoid{.acceleration = {1, 0, 2}, .angular_frequency = 3.1, .phase = 0.2});
  return scene;
}

// Position and velocity after `steps` steps of a single particle at (1, 0, 0) with velocity (0, 1, 0).
std::vector<double> one_particle(const Scene& scene, double h, std::size_t steps) {
  const Plan<double> plan = std::move(*compile<double>(scene, {.step = h}));
  Soa<double> memory(1);
  State<double> state = memory.view();
  state.x[0][0] = 1;
  state.v[1][0] = 1;
  (void)plan.step(state, steps);
  return test::values_of(state);
}

TEST_CASE_TEMPLATE("n steps in one call are n calls of one step, bit by bit, in every scene", T, float, double) {
  for (const NamedScene& scene : test::all_scenes(count)) {
    const Plan<T> plan = make_plan<T>(scene.scene, scene.step);
    for (const std::size_t steps : {0U, 1U, 2U, 31U, 33U, 100U}) {
      Moving<T> at_once, one_by_one;
      at_once.step(plan, steps);
      for (std::size_t k = 0; k < steps; ++k) one_by_one.step(plan);
      const std::string difference = test::difference(at_once.values(), one_by_one.values());
      CHECK_MESSAGE(difference.empty(), scene.name << ", " << steps << " steps: " << difference);
      CHECK(is_close(at_once.state().clock.seconds, scene.step * static_cast<double>(steps), 1e-12));
    }
  }
}

TEST_CASE_TEMPLATE("a step forwards and one back, a hundred times each, end at the start", T, float, double) {
  const double h = 1.0 / 60;
  const Plan<T> forwards = make_plan<T>(undamped<T>(), h), backwards = make_plan<T>(undamped<T>(), -h);
  Moving<T> there;
  const std::vector<T> start = there.values();
  there.step(forwards, 100).step(backwards, 100);
  CHECK(largest_difference(start, there.values()) <= (sizeof(T) == 8 ? 1e-11 : 2e-5));
  CHECK(std::abs(there.state().clock.seconds) < 1e-15);
}

TEST_CASE_TEMPLATE("a damped scene runs back to its start to rounding, amplified as the damping is undone", T, float, double) {
  Scene scene;
  scene.add(Spring{.stiffness = 30.0, .damping = 0.8, .anchor = Vec3{0.1, -0.2, 0.3}});
  const double h = 1.0 / 60;
  Moving<T> there;
  const std::vector<T> start = there.values();
  there.step(make_plan<T>(scene, h), 100).step(make_plan<T>(scene, -h), 100);
  const double amplified = std::exp(0.8 * 100 * h / 2);
  CHECK(largest_difference(start, there.values()) <= amplified * (sizeof(T) == 8 ? 1e-11 : 2e-5));
}

TEST_CASE("combined: n steps of h are one of n h, to rounding") {
  const Spring spring{.stiffness = {30, 5, 0.5}, .damping = 0.3, .anchor = Vec3{0.1, -0.2, 0.3}};
  const std::vector<std::vector<Force>> lists = {
      {spring},
      {spring, Constant{.acceleration = {0, -9.81, 0}}, Drag{.coefficient = 0.4, .wind = {1, 2, 3}}},
      {spring, Sinusoid{.acceleration = {1, 0, 2}, .angular_frequency = 3.1, .phase = 0.2}},
      {Spring{.stiffness = 9.0}, Sinusoid{.acceleration = {1, 0, 2}, .angular_frequency = 3.0}},  // at resonance
      {spring, Polynomial{.acceleration = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.1, 0.1, 0.1}}}},
      {Constant{.acceleration = {0, -9.81, 0}}, Drag{.coefficient = 0.4, .wind = {1, 2, 3}}}};
  for (const auto& forces : lists) {
    Scene scene;
    scene.forces = forces;
    const std::vector<double> many = one_particle(scene, 0.01, 64);
    const std::vector<double> one = one_particle(scene, 0.64, 1);
    CHECK(largest_difference(many, one) <= 5e-13);
  }
}

TEST_CASE("average acceleration moves x by the mean of both velocities, pulse and symplectic Euler by the new one") {
  constexpr double h = 0.05;
  const std::vector<Force> forces = {Spring{.stiffness = 90.0, .damping = 3, .anchor = Vec3{0.25, 0, 0}},
                                     Polynomial{.acceleration = {{1, 2, 0}, {30, 0, 0}, {0, 400, 0}}},
                                     Sinusoid{.acceleration = {1, 2, 0}, .angular_frequency = 20, .phase = 0.3}};
  for (const Force& force : forces) {
    for (const Method method : {Method::average_acceleration, Method::pulse, Method::symplectic_euler}) {
      CAPTURE(force.index());
      CAPTURE(static_cast<int>(method));
      Scene scene;
      scene.method = method;
      scene.add(force);
      const std::vector<double> after = one_particle(scene, h, 1);
      const std::array<double, 2> x = {1, 0}, v = {0, 1};
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const double v_after = after[3 + axis];
        const double speed = method == Method::average_acceleration ? 0.5 * (v[axis] + v_after) : v_after;
        CHECK(std::abs(after[axis] - (x[axis] + h * speed)) <= 1e-15);
        CHECK(v_after != v[axis]);
      }
    }
  }
}

TEST_CASE("four times the mass on four times the stiffness and damping moves alike, by every method") {
  const auto scene_of = [](Method method, double times) {
    Scene scene;
    scene.method = method;
    scene.mass = times;
    scene.add(Spring{.stiffness = {30 * times, 5 * times, times}, .damping = 0.3 * times, .anchor = Vec3{0.1, -0.2, 0.3}});
    scene.add(Drag{.coefficient = 0.7 * times, .wind = {1, 2, 3}});
    scene.add(RadialSpring{.stiffness = 12 * times, .damping = 0.4 * times, .anchor = Vec3{0, 2, 0}, .rest_length = 0.5});
    return scene;
  };
  for (const Method method :
       {Method::combined, Method::exact, Method::average_acceleration, Method::pulse, Method::symplectic_euler}) {
    CAPTURE(static_cast<int>(method));
    CHECK(one_particle(scene_of(method, 4), 0.02, 50) == one_particle(scene_of(method, 1), 0.02, 50));
  }
}

TEST_CASE("where springs to different anchors balance, a particle stays at rest") {
  Scene scene;
  scene.add(Spring{.stiffness = 10.0, .anchor = Vec3{4, 0, 8}});
  scene.add(Spring{.stiffness = 30.0, .damping = 0.2, .anchor = Vec3{0, 0, -8.0 / 3}});
  const std::vector<double> after = one_particle(scene, 0.05, 100);  // starts at (1, 0, 0) with (0, 1, 0)
  CHECK(std::abs(after[0] - 1) <= 1e-13);
  CHECK(std::abs(after[2]) <= 1e-13);
}

TEST_CASE("where a wind and a spring balance, a particle stays at rest") {
  Scene scene;
  scene.add(Spring{.stiffness = 16.0});
  scene.add(Drag{.coefficient = 2.0, .wind = {8, 0, 0}});
  CHECK(std::abs(one_particle(scene, 0.05, 100)[0] - 1) <= 1e-13);
}

TEST_CASE("a velocity below the least normal number moves nothing") {
  Soa<double> memory(1);
  State<double> state = memory.view();
  state.v[0][0] = 1e-310;
  (void)std::move(*compile<double>(Scene{}, {.step = 1e9})).step(state);
  CHECK(state.x[0][0] == 0);
}

TEST_CASE("forces of one kind add up") {
  Scene many, one;
  many.add(Spring{.stiffness = 3.0}).add(Constant{.acceleration = {1, 2, 0}}).add(Constant{.acceleration = {0.5, -9, 4}});
  many.add(Polynomial{.acceleration = {{1, 0, 0}, {0, 2, 0}}})
      .add(Polynomial{.acceleration = {{0, 0, 1}, {0, 1, 1}, {3, 0, 0}}});
  one.add(Spring{.stiffness = 3.0}).add(Constant{.acceleration = {1.5, -7, 4}});
  one.add(Polynomial{.acceleration = {{1, 0, 1}, {0, 3, 1}, {3, 0, 0}}});
  CHECK(largest_difference(one_particle(many, 0.05, 20), one_particle(one, 0.05, 20)) <= 1e-14);
}

TEST_CASE_TEMPLATE("fixed particles keep their bits, and their neighbours move as if they moved too", T, float, double) {
  for (const NamedScene& scene : test::all_scenes(count)) {
    Scene pinned = scene.scene, loose = scene.scene;
    pinned.fixed = {0, 7, 15, 16, 20};
    loose.fixed = {};
    Moving<T> a, b;
    const std::vector<T> start = a.values();
    a.step(make_plan<T>(pinned, scene.step), 9);
    b.step(make_plan<T>(loose, scene.step), 9);
    std::vector<T> wanted = b.values();
    for (const std::size_t i : pinned.fixed)
      std::copy_n(start.begin() + 6 * static_cast<long>(i), 6, wanted.begin() + 6 * static_cast<long>(i));
    CHECK_MESSAGE(test::difference(wanted, a.values()).empty(), scene.name);
  }
}

TEST_CASE("a state that the plan cannot step is told apart, and is left as it was") {
  const NamedScene each = test::affine_scenes(count)[9];
  const Plan<float> plan = make_plan<float>(each.scene, each.step);
  Batch<float> other(Layout::soa, count + 1);
  test::place(other.view());
  const std::vector<float> before = test::values_of(other.view());
  CHECK(plan.step(other.view()) == StepResult::count_differs);
  CHECK(test::difference(before, test::values_of(other.view())).empty());
  CHECK(other.view().clock.seconds == 0);

  Batch<float> batch(Layout::soa, count);
  test::place(batch.view());
  State<float> small = batch.view();
  small.v[2].capacity = count - 1;
  CHECK(plan.step(small) == StepResult::capacity_too_small);
  CHECK(small.clock.seconds == 0);
}

TEST_CASE_TEMPLATE("a state whose time is not finite is not stepped, by any of a plan's ways to step", T, float, double) {
  Scene alone = test::affine_scenes(count)[9].scene, joined = alone;
  joined.add(Network(Springs{.pairs = {{0, 1}, {1, 2}}, .stiffness = 10.0}));
  using Limits = std::numeric_limits<double>;
  for (const Scene& scene : {alone, joined}) {
    for (const double h : {0.01, 0.0}) {
      const Plan<T> plan = make_plan<T>(scene, h);
      Workspace<T> workspace = plan.workspace();
      ContactReport report(0);
      for (const double wrong : {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity()}) {
        for (const Clock clock : {Clock{wrong, 0}, Clock{1, wrong}}) {
          Batch<T> batch(Layout::soa, count);
          test::place(batch.view());
          State<T> state = batch.view();
          state.clock = clock;
          const std::vector<T> before = test::values_of(state);
          CHECK(plan.step(state) == StepResult::time_not_finite);
          CHECK(plan.step(state, std::size_t{0}) == StepResult::time_not_finite);
          CHECK(plan.step(state, workspace) == StepResult::time_not_finite);
          CHECK(plan.step(state, report) == StepResult::time_not_finite);
          CHECK(plan.step(state, workspace, report) == StepResult::time_not_finite);
          CHECK(test::difference(before, test::values_of(state)).empty());
          CHECK(std::isfinite(state.clock.carry) == std::isfinite(clock.carry));
        }
      }
    }
  }
}

TEST_CASE("a plan for particles that are alike steps any number of them") {
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  const auto plan = compile<float>(scene, {});
  for (const std::size_t n : {0U, 1U, 1000U}) {
    Soa<float> memory(n);
    State<float> state = memory.view();
    CHECK(plan->step(state) == StepResult::done);
  }
}

TEST_CASE("no steps change nothing, not even the bits of zeros and denormals") {
  const Plan<float> plan = make_plan<float>(undamped<float>(), 0.01);
  Moving<float> still;
  still.state().x[0][0] = -0.0F;
  still.state().x[0][1] = 1e-41F;
  const std::vector<float> before = still.values();
  still.step(plan, 0);
  CHECK(test::difference(before, still.values()).empty());
  CHECK(still.state().clock.seconds == 0);
}

TEST_CASE_TEMPLATE("a step of no time changes no bit, in every scene", T, float, double) {
  constexpr std::size_t particles = 20;
  for (const test::NamedScene& scene : test::all_scenes(particles)) {
    CAPTURE(scene.name);
    test::Batch<T> batch(test::Layout::soa, particles);
    test::place(batch.view());
    batch.view().x[0][0] = T(-0.0);
    batch.view().v[0][1] = std::numeric_limits<T>::denorm_min();
    const std::vector<T> before = test::values_of(batch.view());
    const auto plan = compile<T>(scene.scene, {.step = 0}, batch.view());
    REQUIRE(plan.has_value());
    CHECK(plan->step(batch.view(), 3) == StepResult::done);
    CHECK(test::difference(before, test::values_of(batch.view())).empty());
    CHECK(batch.view().clock.seconds == 0);
  }
}

}  // namespace step_test
