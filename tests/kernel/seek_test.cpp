// Many steps at once give the same motion as single steps.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "support/batch.hpp"
#include "support/scenes.hpp"

namespace seek_test {

using namespace dvdx;
using test::Batch;
using test::Layout;
using test::NamedScene;

constexpr std::size_t count = 19;

template <class T>
Plan<T> make_plan(const NamedScene& scene) {
  Batch<T> batch(Layout::soa, count);
  test::place(batch.view());
  auto plan = compile<T>(scene.scene, {.step = scene.step}, batch.view());
  REQUIRE_MESSAGE(plan.has_value(), plan.error().message());
  return std::move(*plan);
}

template <class T>
double relative_difference(const std::vector<T>& a, const std::vector<T>& b) {
  double largest = 0, size = 1;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i])));
    size = std::max(size, std::abs(static_cast<double>(a[i])));
  }
  return largest / size;
}

Error refusal(const Scene& scene) {
  Batch<double> batch(Layout::soa, count);
  const auto plan = compile<double>(scene, {}, batch.view());
  REQUIRE(plan.has_value());
  const auto sought = plan->seek(batch.view(), 10);
  REQUIRE_FALSE(sought.has_value());
  CHECK(batch.view().clock.seconds == 0);
  return sought.error();
}

TEST_CASE_TEMPLATE("seek goes where steps go, in every affine scene", T, float, double) {
  for (const NamedScene& scene : test::affine_scenes(count)) {
    if (!scene.scene.fixed.empty()) continue;
    const Plan<T> plan = make_plan<T>(scene);
    for (const std::size_t steps : {0U, 1U, 7U, 600U}) {
      Batch<T> walked(Layout::soa, count), jumped(Layout::aosoa8, count);
      for (auto* batch : {&walked, &jumped}) {
        test::place(batch->view());
        batch->view().clock.advance(0.37, 1);
      }
      REQUIRE(plan.step(walked.view(), steps) == StepResult::done);
      REQUIRE(plan.seek(jumped.view(), steps).has_value());
      const double bound = (sizeof(T) == 8 ? 1e-14 : 8e-7) * static_cast<double>(10 + steps);
      CHECK_MESSAGE(relative_difference(test::values_of(walked.view()), test::values_of(jumped.view())) <= bound,
                    scene.name << ", " << steps << " steps");
      CHECK(std::abs(jumped.view().clock.seconds - walked.view().clock.seconds) <= 1e-14);
      CHECK(jumped.is_clean());
    }
  }
}

TEST_CASE("a spring far ahead is where its closed form says") {
  NamedScene scene{.name = "spring", .scene = {}, .step = 0.01};
  scene.scene.add(Spring{.stiffness = 4.0});
  Batch<double> batch(Layout::soa, count);
  batch.view().x[0][3] = 1;
  REQUIRE(make_plan<double>(scene).seek(batch.view(), 1000000).has_value());  // t = 10000 s
  CHECK(std::abs(batch.view().x[0][3] - std::cos(20000.0)) <= 1e-9);
  CHECK(std::abs(batch.view().v[0][3] + 2 * std::sin(20000.0)) <= 1e-9);
}

TEST_CASE("seek refuses what is not affine, names it, and moves nothing") {
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  Scene bouncing = scene;
  bouncing.add(Plane{});
  CHECK(refusal(bouncing).field == "contacts");
  Scene radial = scene;
  radial.add(RadialSpring{.stiffness = 3.0, .rest_length = 0.5});
  CHECK(refusal(radial).field == "forces[1]");
  Scene fixed = scene;
  fixed.fixed = {2};
  CHECK(refusal(fixed).field == "fixed");
}

TEST_CASE("seek refuses a state of another count, or with a column that is too short") {
  const NamedScene each = test::affine_scenes(count)[9];
  const Plan<double> plan = make_plan<double>(each);
  Batch<double> other(Layout::soa, count + 1);
  CHECK(plan.seek(other.view(), 3).error().field == "state.count");
  Batch<double> batch(Layout::soa, count);
  State<double> small = batch.view();
  small.x[1].capacity = count - 1;
  CHECK_FALSE(plan.seek(small, 3).has_value());
}

TEST_CASE("seek refuses a state whose time is not finite, and moves nothing") {
  const Plan<double> plan = make_plan<double>(test::affine_scenes(count)[9]);
  Batch<double> batch(Layout::soa, count);
  test::place(batch.view());
  const std::vector<double> before = test::values_of(batch.view());
  State<double> state = batch.view();
  state.clock.seconds = std::numeric_limits<double>::quiet_NaN();
  CHECK(plan.seek(state, 3).error().message() == "state.clock is nan: must be a finite time");
  state.clock = {1, -std::numeric_limits<double>::infinity()};
  CHECK(plan.seek(state, 3).error().message() == "state.clock is -inf: must be a finite time");
  CHECK(test::difference(before, test::values_of(state)).empty());
}

}  // namespace seek_test
