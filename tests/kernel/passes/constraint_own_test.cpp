// Constraints supplied by the user.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "dvdx/constrain.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/constrained.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/batch.hpp"

namespace constrained::own_test {

using test::Batch;
using test::Layout;
using test::stepped;

struct OnSphere {
  double radius;
  template <class R>
  R operator()(const std::array<R, 3>& at, std::array<R, 3>& gradient) const {
    for (std::size_t axis = 0; axis < 3; ++axis) gradient[axis] = 2.0 * at[axis];
    return at[0] * at[0] + at[1] * at[1] + at[2] * at[2] - radius * radius;
  }
};

struct OnPlane {
  template <class R>
  R operator()(const std::array<R, 3>& at, std::array<R, 3>& gradient) const {
    gradient = {0.6, 0.8, 0.0};
    return 0.6 * at[0] + 0.8 * at[1];
  }
};

// 37 particles on the sphere of radius 1, at rest.
template <class T>
void place_on_sphere(State<T>& state) {
  for (std::size_t i = 0; i < state.count; ++i) {
    Vec3 at = {test::scatter(i, 0), test::scatter(i, 1), test::scatter(i, 2)};
    const double r = std::hypot(at[0], at[1], at[2]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.x[axis][i] = static_cast<T>(at[axis] / r);
      state.v[axis][i] = T(0);
    }
  }
}

template <class T, class... C>
std::vector<T> slid(Layout layout, std::size_t steps, std::size_t bad, const C&... constraints) {
  Batch<T> batch(layout, 37);
  Batch<T> start(Layout::soa, 37);
  place_on_sphere(batch.view());
  if (bad < 37) batch.view().v[1][bad] = std::numeric_limits<T>::quiet_NaN();
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  const auto plan = compile<T>(scene, {.step = 1.0 / 240});
  REQUIRE(plan.has_value());
  for (std::size_t n = 0; n < steps; ++n) {
    copy(batch.view(), start.view());
    REQUIRE(plan->step(batch.view()) == StepResult::done);
    constrain(start.view(), batch.view(), plan->step_size(), constraints...);
  }
  CHECK(batch.is_clean());
  return test::values_of(batch.view());
}

TEST_CASE("constraint of your own: a sphere is a rod to its centre") {
  const auto got = slid<double>(Layout::aos, 240, 37, OnSphere{1});
  Joined rods = under_gravity("rods", 9.81);
  Batch<double> start(Layout::soa, 37);
  place_on_sphere(start.view());
  Distance distance{.pairs = {}, .length = 1.0};
  for (std::uint32_t i = 0; i < 37; ++i) {
    rods.x.push_back({start.view().x[0][i], start.view().x[1][i], start.view().x[2][i]});
    distance.pairs.push_back({i, 37});
  }
  rods.x.push_back({0, 0, 0});
  rods.v.resize(38);
  rods.scene.add(distance);
  rods.scene.fixed = {37};
  rods.step = 1.0 / 240;
  const auto wanted = stepped<double>(rods, {.isa = best_isa()}, 240);
  double worst = 0;
  for (std::size_t k = 0; k < got.size(); ++k) worst = std::max(worst, std::abs(got[k] - wanted[k]));
  CHECK(worst <= 1e-10);
}

TEST_CASE_TEMPLATE("constraint of your own: two surfaces hold particles on a curve, in any layout, and a bad one stays alone",
                   T, float, double) {
  const auto wanted = slid<T>(Layout::soa, 20, 37, OnSphere{1}, OnPlane{});
  for (std::size_t i = 0; i < 37; ++i) {
    const double off = 0.6 * static_cast<double>(wanted[6 * i]) + 0.8 * static_cast<double>(wanted[6 * i + 1]);
    CHECK(std::abs(off) <= (sizeof(T) == 4 ? 1e-5 : 1e-8));
  }
  for (const Layout layout : test::layouts) {
    CHECK(test::difference(wanted, slid<T>(layout, 20, 37, OnSphere{1}, OnPlane{})) == "");
  }
  std::vector<T> one_bad = slid<T>(Layout::soa, 20, 9, OnSphere{1}, OnPlane{});
  std::copy_n(wanted.begin() + 54, 6, one_bad.begin() + 54);
  CHECK(test::difference(wanted, one_bad) == "");
}

}  // namespace constrained::own_test
