// Constraints: the pendulum's closed form, order, what must be kept, bounds, and the scalar twins' bits.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "support/batch.hpp"
#include "support/oracle.hpp"
#include "support/threads.hpp"

namespace {

using namespace dvdx;
using test::Batch;
using test::Joined;
using test::Layout;

struct Run {
  Isa isa = Isa::reference;
  Arithmetic arithmetic = Arithmetic::separate;
  Layout layout = Layout::soa;
  std::size_t threads = 1;
};

template <class T>
Plan<T> plan_of(const Joined& joined, const Run& run, const State<T>& start) {
  auto plan = compile<T>(joined.scene, {.step = joined.step, .isa = run.isa, .arithmetic = run.arithmetic}, start);
  REQUIRE_MESSAGE(plan.has_value(), joined.name << ": " << plan.error().message());
  return std::move(*plan);
}

template <class T>
std::vector<T> stepped(const Joined& joined, const Run& run, std::size_t steps) {
  Batch<T> batch(run.layout, joined.x.size());
  test::place(joined, batch.view());
  const Plan<T> plan = plan_of(joined, run, batch.view());
  test::Threads workers(run.threads);
  const ParallelFor parallel = run.threads > 1 ? workers.parallel_for() : ParallelFor{};
  REQUIRE(plan.step(batch.view(), steps, parallel) == StepResult::done);
  CHECK(batch.is_clean());
  return test::values_of(batch.view());
}

double x(const std::vector<double>& values, std::size_t i, std::size_t axis) { return values[6 * i + axis]; }
double v(const std::vector<double>& values, std::size_t i, std::size_t axis) { return values[6 * i + 3 + axis]; }
double length(const std::vector<double>& values, std::size_t i, std::size_t j) {
  return std::hypot(x(values, j, 0) - x(values, i, 0), x(values, j, 1) - x(values, i, 1), x(values, j, 2) - x(values, i, 2));
}

Joined under_gravity(std::string name, double g) {
  Joined joined;
  joined.name = std::move(name);
  joined.scene.add(Constant{.acceleration = {0, -g, 0}});
  return joined;
}

// A bob on a rod of length l from a fixed point, at rest at an angle from the vertical.
Joined pendulum(double l, double angle, double g, double step) {
  Joined joined = under_gravity("pendulum", g);
  joined.x = {{0, 0, 0}, {l * std::sin(angle), -l * std::cos(angle), 0}};
  joined.v.resize(2);
  joined.scene.fixed = {0};
  joined.scene.add(Distance{.pairs = {{0, 1}}, .length = l});
  joined.step = step;
  return joined;
}

std::size_t steps_in(double time, double step) { return static_cast<std::size_t>(std::lround(time / step)); }

}  // namespace

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
  for (std::size_t n = 1; n <= 120; ++n) {
    const auto got = stepped<double>(coarse, {.isa = best_isa()}, n);
    const auto wanted = stepped<double>(fine, {.isa = best_isa()}, 100 * n);
    squares += std::pow(x(got, 1, 0) - x(wanted, 1, 0), 2) + std::pow(x(got, 1, 1) - x(wanted, 1, 1), 2);
  }
  const double rms = std::sqrt(squares / 120);
  const auto end = stepped<double>(coarse, {.isa = best_isa()}, 600);
  const double energy = 9.81 * x(end, 1, 1) + (std::pow(v(end, 1, 0), 2) + std::pow(v(end, 1, 1), 2)) / 2;
  MESSAGE("position error over 2 s " << rms << " m rms, energy after 10 s " << energy << " J/kg of 9.81");
  CHECK(rms <= 1.6e-3);
  CHECK(std::abs(energy) <= 1e-2);
}
