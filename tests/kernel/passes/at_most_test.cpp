// Limits: `at_most` constraints that share particles. They rest, keep their lengths, and more iterations never make them worse.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/batch.hpp"

namespace at_most_test {

using namespace dvdx;
using test::Joined;
using test::Run;
using test::stepped;

// n particles held at both ends that hang with their own lengths: a parabola is at rest.
Joined hanging(std::uint32_t n) {
  Joined joined;
  joined.name = "chain of " + std::to_string(n);
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  Distance links{.pairs = {}, .bound = Bound::at_most};
  for (std::uint32_t i = 0; i < n; ++i) {
    const double u = i / (n - 1.0);
    joined.x.push_back({12 * u, -6 * u * (1 - u), 0});
    if (i != 0) links.pairs.push_back({i - 1, i});
  }
  joined.v.resize(n);
  joined.scene.add(links);
  joined.scene.fixed = {0, n - 1};
  return joined;
}

// Rows and columns of 12 x 12 particles below the fixed ones: the top row, or its two corners.
Joined curtain(bool hangs_at_corners) {
  constexpr std::uint32_t side = 12;
  Joined joined;
  joined.name = hangs_at_corners ? "curtain at its corners" : "curtain";
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  Distance links{.pairs = {}, .bound = Bound::at_most};
  for (std::uint32_t i = 0; i < side * side; ++i) {
    joined.x.push_back({0.05 * (i % side), -0.05 * (i / side), 0});
    if (i % side != 0) links.pairs.push_back({i - 1, i});
    if (i >= side) links.pairs.push_back({i - side, i});
  }
  joined.v.resize(joined.x.size());
  joined.scene.add(links);
  for (std::uint32_t i = 0; i < side; i += hangs_at_corners ? side - 1 : 1) joined.scene.fixed.push_back(i);
  return joined;
}

struct Seen {
  double speed = 0, stretch = 0, energy = 0;  // energy: the largest excess over the start's, J/kg
};

double length(const std::vector<double>& values, const Pair& pair) {
  double square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) square += std::pow(values[6 * pair[1] + axis] - values[6 * pair[0] + axis], 2);
  return std::sqrt(square);
}

double energy(const Joined& joined, const std::vector<double>& values) {
  double sum = 0;
  double mass = 0;
  for (std::size_t i = 0; i < joined.x.size(); ++i) {
    const double* const of = &values[6 * i];
    sum += joined.scene.mass[i] * (9.81 * of[1] + (of[3] * of[3] + of[4] * of[4] + of[5] * of[5]) / 2);
    mass += joined.scene.mass[i];
  }
  return sum / mass;
}

// Observed after each of `lots` runs of `steps` steps; the speed is that after the last.
template <class T>
Seen watched(Joined joined, int iterations, int substeps, std::size_t lots, std::size_t steps) {
  joined.scene.coupling.iterations = iterations;
  joined.scene.coupling.substeps = substeps;
  test::Batch<T> batch(test::Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const Plan<T> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
  const auto values = [&] {
    const std::vector<T> now = test::values_of(batch.view());
    return std::vector<double>(now.begin(), now.end());
  };
  const std::vector<double> start = values();
  const auto& pairs = std::get<Distance>(joined.scene.constraints[0]).pairs;
  Seen seen{.energy = -std::numeric_limits<double>::infinity()};
  for (std::size_t lot = 0; lot < lots; ++lot) {
    REQUIRE(plan.step(batch.view(), steps) == StepResult::done);
    const std::vector<double> now = values();
    for (const Pair& pair : pairs) seen.stretch = std::max(seen.stretch, length(now, pair) / length(start, pair) - 1);
    seen.energy = std::max(seen.energy, energy(joined, now) - energy(joined, start));
    seen.speed = 0;
    for (std::size_t i = 0; i < joined.x.size(); ++i) {
      seen.speed = std::max(seen.speed, std::hypot(now[6 * i + 3], now[6 * i + 4], now[6 * i + 5]));
    }
  }
  return seen;
}

// Chains that cross and meet, of all masses, slack and taut, held at several places.
Joined tangle() {
  Joined joined = curtain(true);
  joined.name = "tangle";
  std::vector<double> masses;
  for (std::size_t i = 0; i < joined.x.size(); ++i) {
    masses.push_back(i % 29 == 0 ? 40 : 1.5 + test::scatter(i, 6));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      joined.x[i][axis] += 0.02 * test::scatter(i, axis);
      joined.v[i][axis] = 3 * test::scatter(i, 3 + axis);
    }
  }
  joined.scene.mass = Scalars(masses);
  auto& links = std::get<Distance>(joined.scene.constraints[0]);
  for (std::uint32_t i = 0; i + 13 < joined.x.size(); i += 3) links.pairs.push_back({i, i + 13});
  links.length = 0.055;
  Distance rods{.pairs = {{3, 16}, {40, 53}}, .length = std::nullopt};
  joined.scene.add(rods);
  joined.scene.fixed.push_back(77);
  return joined;
}

template <class T>
void check_bits(const Joined& joined, Arithmetic arithmetic) {
  const std::vector<T> wanted = stepped<T>(joined, {.arithmetic = arithmetic}, 3);
  for (const Isa isa : available_isas(arithmetic)) {
    const std::string difference = test::difference(wanted, stepped<T>(joined, {.isa = isa, .arithmetic = arithmetic}, 3));
    CHECK_MESSAGE(difference.empty(), joined.name << ", " << 8 * sizeof(T) << " bits, " << name(isa) << ": " << difference);
  }
}

TEST_CASE_TEMPLATE("limits: a chain at rest stays at rest by any number of iterations", T, float, double) {
  for (const std::uint32_t n : {10U, 24U, 101U}) {
    for (const int iterations : {8, 16, 32, 100, 200}) {
      const Seen seen = watched<T>(hanging(n), iterations, 1, 5, 12);
      CAPTURE(n);
      CAPTURE(iterations);
      CHECK(seen.speed <= (sizeof(T) == 4 ? 1e-3 : 1e-9));
      CHECK(seen.stretch <= (sizeof(T) == 4 ? 2e-5 : 1e-12));
      CHECK(seen.energy <= (sizeof(T) == 4 ? 1e-4 : 1e-12));
    }
  }
}

TEST_CASE_TEMPLATE("limits: a bridge with a man in its middle keeps its length and gains no energy", T, float, double) {
  for (const std::uint32_t n : {11U, 25U, 101U}) {
    Joined bridge = hanging(n);
    std::vector<double> masses(n, 1.0);
    masses[n / 2] = 80;
    bridge.scene.mass = Scalars(masses);
    for (const int iterations : {8, 32, 100}) {
      for (const int substeps : {1, 4}) {
        const Seen seen = watched<T>(bridge, iterations, substeps, 10, 6);
        CAPTURE(n);
        CAPTURE(iterations);
        CAPTURE(substeps);
        CHECK(seen.stretch <= (sizeof(T) == 4 ? 1e-4 : 1e-9));
        CHECK(seen.energy <= (sizeof(T) == 4 ? 1e-3 : 1e-5));
      }
    }
  }
}

TEST_CASE_TEMPLATE("limits: a curtain of crossing limits rests, and more iterations are never worse", T, float, double) {
  for (const int substeps : {1, 4}) {
    double before = std::numeric_limits<double>::infinity();
    for (const int iterations : {8, 16, 32, 100}) {
      if (iterations * substeps > 200) continue;
      const Seen seen = watched<T>(curtain(false), iterations, substeps, 10, 6);
      CAPTURE(iterations);
      CAPTURE(substeps);
      CHECK(seen.speed <= (sizeof(T) == 4 ? 1e-3 : 1e-9));
      CHECK(seen.stretch <= 1.02 * before + 1e-5);
      if (iterations >= 32) CHECK(seen.stretch <= 0.01);
      before = seen.stretch;
    }
  }
}

TEST_CASE_TEMPLATE("limits: a curtain that falls into its corners gains no energy", T, float, double) {
  for (const int substeps : {1, 4}) {
    for (const int iterations : {8, 32}) {
      Joined thrown = curtain(true);
      for (std::size_t i = 0; i < thrown.v.size(); ++i) thrown.v[i] = {test::scatter(i, 0), test::scatter(i, 1), 2.0};
      const Seen seen = watched<T>(thrown, iterations, substeps, 15, 4);
      CAPTURE(iterations);
      CAPTURE(substeps);
      CHECK(seen.energy <= 0);
    }
  }
}

TEST_CASE("limits: crossing limits that are slack move nothing") {
  Joined slack = curtain(false);
  for (std::size_t i = 0; i < slack.v.size(); ++i) slack.v[i] = {0.3 * test::scatter(i, 0), 0, test::scatter(i, 1)};
  Joined free = slack;
  free.scene.constraints.clear();
  std::get<Distance>(slack.scene.constraints[0]).length = Scalars(1.0);
  slack.scene.coupling.substeps = free.scene.coupling.substeps = 1;
  const auto wanted = stepped<double>(free, {}, 3);
  const auto got = stepped<double>(slack, {}, 3);
  for (std::size_t k = 0; k < wanted.size(); ++k) CHECK(std::abs(got[k] - wanted[k]) <= 1e-13);
}

TEST_CASE("limits: every ISA gives the scalar reference's bits") {
  Joined slow = hanging(24);
  std::vector<double> masses(24, 1.0);
  masses[9] = 80;
  slow.scene.mass = Scalars(masses);
  for (Joined joined : {slow, tangle()}) {
    const bool is_slow = joined.x.size() == 24;
    // Both scenes with every precision and every arithmetic.
    check_bits<float>(joined, is_slow ? Arithmetic::separate : Arithmetic::contracted);
    check_bits<double>(joined, is_slow ? Arithmetic::contracted : Arithmetic::separate);
    joined.step = -joined.step;
    joined.scene.coupling.substeps = 3;
    check_bits<float>(joined, Arithmetic::separate);
  }
}

TEST_CASE("limits: a step back with reversed velocities mirrors a step forwards") {
  std::vector<double> after[2];
  for (const double sign : {1.0, -1.0}) {
    Joined joined = tangle();
    joined.step = sign / 60;
    for (Vec3& v : joined.v) v = {sign * v[0], sign * v[1], sign * v[2]};
    after[sign < 0 ? 1 : 0] = stepped<double>(joined, {}, 2);
  }
  for (std::size_t k = 0; k < after[0].size(); ++k) CHECK(after[0][k] == (k % 6 < 3 ? 1 : -1) * after[1][k]);
}

TEST_CASE("limits: a bad particle stays alone") {
  Joined joined = hanging(24);
  std::get<Distance>(joined.scene.constraints[0]).length = Scalars(0.6);
  joined.x[11][2] = std::numeric_limits<double>::quiet_NaN();
  joined.v[5][0] = std::numeric_limits<double>::quiet_NaN();
  const auto got = stepped<double>(joined, {.isa = best_isa()}, 60);
  for (std::size_t i = 0; i < 24; ++i) {
    const bool is_bad = i == 11 || i == 5;
    for (std::size_t k = 0; k < 6 && !is_bad; ++k) CHECK(std::isfinite(got[6 * i + k]));
  }
}

}  // namespace at_most_test
