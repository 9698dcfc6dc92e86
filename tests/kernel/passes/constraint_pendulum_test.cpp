// Constraints: the pendulum's closed form, and a string that becomes taut within a step.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/constrained.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/batch.hpp"
#include "support/oracle.hpp"

namespace constrained::pendulum_test {

using test::Batch;
using test::Layout;
using test::plan_of;
using test::stepped;

std::size_t steps_in(double time, double step) { return static_cast<std::size_t>(std::lround(time / step)); }

TEST_CASE("constraint: pendulums follow their closed form, with the square of the step") {
  const test::Oracle oracle("pendulum.csv");
  double worst_60 = 0;
  double worst_240 = 0;
  double squares = 0;
  double rows = 0;
  double worst_stretch = 0;
  for (std::size_t r = 0; r < oracle.size(); ++r) {
    const auto row = oracle[r];
    if (row["t_s"] > 2) continue;
    const auto error = [&](double hertz) {
      const Joined joined = pendulum(row["L_m"], row["theta0"], row["g_m"], 1 / hertz);
      const auto got = stepped<double>(joined, {.isa = best_isa()}, steps_in(row["t_s"], joined.step));
      worst_stretch = std::max(worst_stretch, std::abs(length(got, 0, 1) / row["L_m"] - 1));
      return std::hypot(x(got, 1, 0) - row["x_m"], x(got, 1, 1) - row["y_m"]);
    };
    const double at_60 = error(60);
    worst_60 = std::max(worst_60, at_60);
    worst_240 = std::max(worst_240, error(240));
    squares += at_60 * at_60;
    ++rows;
  }
  const double rms = std::sqrt(squares / rows);
  MESSAGE("pendulums over 2 s: position error " << rms << " m rms and " << worst_60 << " m at worst at 60 Hz, " << worst_240
                                                << " m at worst at 240 Hz; stretch " << worst_stretch);
  CHECK(rms <= 2e-3);
  CHECK(worst_60 <= 6e-3);
  CHECK(worst_60 / worst_240 > 14);
  CHECK(worst_stretch <= 1e-15);
}

TEST_CASE("constraint: a pendulum of one metre from 90 degrees, 60 steps a second") {
  const Joined coarse = pendulum(1, std::acos(0.0), 9.81, 1.0 / 60);
  const Joined fine = pendulum(1, std::acos(0.0), 9.81, 1.0 / 6000);
  double squares = 0;
  Batch<double> got(Layout::soa, 2), wanted(Layout::soa, 2);
  test::place(coarse, got.view());
  test::place(fine, wanted.view());
  const auto coarse_plan = plan_of(coarse, {.isa = best_isa()}, got.view());
  const auto fine_plan = plan_of(fine, {.isa = best_isa()}, wanted.view());
  for (std::size_t n = 1; n <= 120; ++n) {
    REQUIRE(coarse_plan.step(got.view(), 1) == StepResult::done);
    REQUIRE(fine_plan.step(wanted.view(), 100) == StepResult::done);
    for (std::size_t axis = 0; axis < 2; ++axis) squares += std::pow(got.view().x[axis][1] - wanted.view().x[axis][1], 2);
  }
  const double rms = std::sqrt(squares / 120);
  const auto end = stepped<double>(coarse, {.isa = best_isa()}, 600);
  const double energy = 9.81 * x(end, 1, 1) + (std::pow(v(end, 1, 0), 2) + std::pow(v(end, 1, 1), 2)) / 2;
  MESSAGE("position error over 2 s " << rms << " m rms, energy after 10 s " << energy << " J/kg of 9.81");
  CHECK(rms <= 1.6e-3);
  CHECK(std::abs(energy) <= 1e-2);
}

// A bob flies until its string of 1 m becomes taut in the middle of the step: (0.5, -0.1) m with (5, 1) m/s reaches (1, 0) m.
// There the string removes the 5 m/s, and the bob moves on along the circle at 1 m/s for the second half of the step.
TEST_CASE("constraint: a string that is drawn in the middle of a step takes the speed along it and leaves the speed across") {
  Joined joined;
  joined.x = {{0, 0, 0}, {0.5, -0.1, 0}};
  joined.v = {{0, 0, 0}, {5, 1, 0}};
  joined.scene.fixed = {0};
  joined.scene.add(Distance{.pairs = {{0, 1}}, .length = 1.0, .bound = Bound::at_most});
  joined.step = 0.2;
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
    for (const Isa isa : available_isas(arithmetic)) {
      CAPTURE(name(isa));
      const auto got = stepped<double>(joined, {.isa = isa, .arithmetic = arithmetic}, 1);
      CHECK(std::abs(length(got, 0, 1) - 1) <= 1e-14);
      CHECK(std::abs(std::atan2(x(got, 1, 1), x(got, 1, 0)) - 0.1) <= 1e-3);
      CHECK(std::abs(v(got, 1, 1) * x(got, 1, 0) - v(got, 1, 0) * x(got, 1, 1) - 1) <= 1e-3);
      CHECK(std::abs(v(got, 1, 0) * x(got, 1, 0) + v(got, 1, 1) * x(got, 1, 1)) <= 1e-14);
    }
  }
}

}  // namespace constrained::pendulum_test
