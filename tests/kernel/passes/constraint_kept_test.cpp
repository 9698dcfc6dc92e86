// Constraints: conserved quantities, bounds, the order of a rope, and bad particles.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/constrained.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/batch.hpp"

namespace constrained::kept_test {

using test::stepped;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

double worst_stretch(const std::vector<double>& values, std::size_t links, double link) {
  double worst = 0;
  for (std::size_t i = 0; i < links; ++i) worst = std::max(worst, std::abs(length(values, i, i + 1) / link - 1));
  return worst;
}

double energy(const Joined& joined, const std::vector<double>& values) {
  double sum = 0;
  for (std::size_t i = 0; i < joined.x.size(); ++i) {
    const double speed = std::hypot(v(values, i, 0), v(values, i, 1), v(values, i, 2));
    sum += joined.scene.mass[i] * (speed * speed / 2 + 9.81 * x(values, i, 1));
  }
  return sum;
}

Joined with_substeps(Joined joined, int substeps) {
  joined.scene.coupling.substeps = substeps;
  return joined;
}

TEST_CASE("constraint: a free rod keeps its momentum, its spin and its length") {
  Joined rod;
  rod.x = {{0, 0, 0}, {1, 0, 0}};
  rod.v = {{0.3, -1, 0.2}, {0.3, 5, -2}};
  rod.scene.mass = std::vector<double>{1, 3};
  rod.scene.add(Distance{.pairs = {{0, 1}}});
  const auto got = stepped<double>(rod, {.isa = best_isa()}, 6000);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double momentum = v(got, 0, axis) + 3 * v(got, 1, axis);
    CHECK(std::abs(momentum - (rod.v[0][axis] + 3 * rod.v[1][axis])) <= 1e-11);
  }
  // The rod turns in the plane of its axis and its ends' velocity difference.
  const double spin = (x(got, 1, 0) - x(got, 0, 0)) * (v(got, 1, 1) - v(got, 0, 1)) -
                      (x(got, 1, 1) - x(got, 0, 1)) * (v(got, 1, 0) - v(got, 0, 0));
  CHECK(std::abs(spin / 6 - 1) <= 1e-11);
  CHECK(std::abs(length(got, 0, 1) - 1) <= 1e-14);
}

TEST_CASE("constraint: a rope of 100 links keeps its lengths and its energy") {
  const Joined coarse = rope(100, 1);  // far too few sub-steps for its fast motion: only the lengths are right
  const Joined fine = with_substeps(coarse, 64);
  const double depth = 0.1 * 9.81;  // J: the scale of the energy error
  for (const std::size_t steps : {30U, 60U, 120U}) {
    const auto fine_end = stepped<double>(fine, {.isa = best_isa()}, steps);
    const double change = std::abs(energy(fine, fine_end)) / depth;
    const double coarse_stretch = worst_stretch(stepped<double>(coarse, {.isa = best_isa()}, steps), 100, 0.01);
    MESSAGE("rope after " << steps << " steps: energy " << change << " of its own with 64 sub-steps a step; stretch "
                          << worst_stretch(fine_end, 100, 0.01) << ", with one sub-step " << coarse_stretch);
    CHECK(worst_stretch(fine_end, 100, 0.01) <= 1e-13);
    CHECK(coarse_stretch <= 1e-13);
    if (steps <= 60) CHECK(change <= 1e-3);
  }
  const auto single = stepped<float>(with_substeps(coarse, 16), {.isa = best_isa()}, 240);
  CHECK(worst_stretch({single.begin(), single.end()}, 100, 0.01) <= 2e-5);
}

TEST_CASE("constraint: a rope is of second order") {
  const Joined joined = rope(10, 1);
  const auto wanted = stepped<double>(with_substeps(joined, 512), {.isa = best_isa()}, 24);
  const auto error = [&](int substeps) {
    const auto got = stepped<double>(with_substeps(joined, substeps), {.isa = best_isa()}, 24);
    return std::hypot(x(got, 10, 0) - x(wanted, 10, 0), x(got, 10, 1) - x(wanted, 10, 1));
  };
  const double of_8 = error(8);
  const double of_32 = error(32);
  MESSAGE("rope of 10 links, tip after 0.4 s: " << of_8 << " m with 8 sub-steps, " << of_32 << " m with 32");
  CHECK(std::log2(of_8 / of_32) / 2 > 1.9);
}

TEST_CASE("constraint: sweeps over single rods lead where a chain's elimination does") {
  // A double pendulum, and the same with a rod to an almost massless particle at its joint, which makes the other two single.
  Joined chain = rope(2, 2);
  chain.x.push_back({1, 1, 0});
  chain.v.resize(4);
  chain.scene.mass = std::vector<double>{1, 1, 1, 1e-10};
  Joined swept = chain;
  std::get<Distance>(swept.scene.constraints[0]).pairs.push_back({1, 3});
  swept.scene.coupling.iterations = 200;
  swept.scene.coupling.substeps = 1;
  const auto a = stepped<double>(chain, {.isa = best_isa()}, 30);
  const auto b = stepped<double>(swept, {.isa = best_isa()}, 30);
  for (std::size_t axis = 0; axis < 2; ++axis) CHECK(std::abs(x(a, 2, axis) - x(b, 2, axis)) <= 1e-8);
}

TEST_CASE("constraint: a rope does nothing while it is slack") {
  Joined slack = rope(1, 1, Bound::at_most);
  slack.x[1] = {0.1, 0, 0};
  slack.v[1] = {1, 2, 0.5};
  Joined loose = slack;
  loose.scene.constraints.clear();
  const auto a = stepped<double>(slack, {}, 15);
  CHECK(test::difference(stepped<double>(loose, {}, 15), a) == "");
  CHECK(length(stepped<double>(slack, {}, 120), 0, 1) <= 1 + 1e-15);
}

TEST_CASE("constraint: a particle that must keep off stays off and does not bounce") {
  Joined joined = under_gravity("two", 0);
  joined.x = {{0, 0, 0}, {2, 0.3, 0}};
  joined.v = {{0, 0, 0}, {-3, 0, 0}};
  joined.scene.fixed = {0};
  joined.scene.add(Distance{.pairs = {{0, 1}}, .length = 1.0, .bound = Bound::at_least});
  double nearest = 9;
  for (std::size_t n = 1; n < 60; ++n) nearest = std::min(nearest, length(stepped<double>(joined, {}, n), 0, 1));
  CHECK(nearest >= 1 - 1e-14);
  CHECK(nearest <= 1 + 1e-3);
  const auto end = stepped<double>(joined, {}, 60);
  CHECK(std::hypot(v(end, 1, 0), v(end, 1, 1)) <= 3);
}

TEST_CASE("constraint: a step back with reversed velocities mirrors a step forwards, for every bound") {
  for (const Bound bound : {Bound::equal, Bound::at_most, Bound::at_least}) {
    std::vector<double> after[2];
    for (const double sign : {1.0, -1.0}) {
      test::Joined joined;
      joined.x = {{0, 0, 0}, {0.9, 0.3, 0}, {1.1, -0.6, 0}};
      for (const double speed : {0.5, 3.0, -2.0}) joined.v.push_back({sign * speed, sign * 2 * speed, 0});
      joined.step = sign / 30;
      joined.scene.add(Distance{.pairs = {{0, 1}, {0, 2}}, .length = Scalars(1.0), .bound = bound});
      after[sign < 0 ? 1 : 0] = test::stepped<double>(joined, {}, 10);
    }
    for (std::size_t k = 0; k < after[0].size(); ++k) CHECK(after[0][k] == (k % 6 < 3 ? 1 : -1) * after[1][k]);
  }
}

// Velocity pulses correct the rounding of position pulses alone: the wrong sign would leave it.
TEST_CASE("constraint: a step back onto a bound leaves no speed off it, as a step forwards leaves none") {
  for (const auto& [bound, out] : {std::pair(Bound::at_most, 1.0), {Bound::at_least, -1.0}}) {
    for (const double sign : {1.0, -1.0}) {
      for (const double begin : {0.99, 0.985, 0.97}) {
        test::Joined joined;
        joined.x = {{0, 0, 0}, {1 + out * (begin - 1), 0, 0}};
        joined.v = {{0, 0, 0}, {sign * out * 2, 0, 0}};
        joined.step = sign / 30;
        joined.scene.fixed = {0};
        joined.scene.add(Distance{.pairs = {{0, 1}}, .length = Scalars(1.0), .bound = bound});
        const auto after = test::stepped<float>(joined, {}, 1);
        CHECK(sign * out * after[9] <= 0);
      }
    }
  }
}

TEST_CASE("constraint: a free chain whose link is turned round in a step keeps its centre of mass") {
  test::Joined joined;
  joined.x = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  joined.v = {{0, 0, 0}, {0, 0, 0}, {0, 1, 0}, {-100, 5, 0}};
  joined.scene.add(Distance{.pairs = {{0, 1}, {1, 2}, {2, 3}}, .length = Scalars(1.0)});
  const auto after = test::stepped<double>(joined, {}, 1);
  double x = 0, y = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    x += after[6 * i] / 4;
    y += after[6 * i + 1] / 4;
  }
  CHECK(std::abs(x - (1.5 - 25 * joined.step)) <= 1e-12);
  CHECK(std::abs(y - 1.5 * joined.step) <= 1e-12);
}

// The chain is swept with the rod, so that its elimination does not converge where links turn round.
TEST_CASE("constraint: a free chain that a rod branches off keeps its centre of mass, however fast its particles go") {
  constexpr std::size_t count = 7;
  for (const Isa isa : {Isa::reference, best_isa()}) {
    test::Joined joined;
    Vec3 middle{};
    Distance links{.pairs = {{1, 6}}, .length = Scalars(1.0)};
    for (std::uint32_t i = 0; i < count; ++i) {
      joined.x.push_back(i < 6 ? Vec3{static_cast<double>(i), 0, 0} : Vec3{1, 1, 0});
      joined.v.push_back({100 * test::scatter(i, 0), 100 * test::scatter(i, 1), 100 * test::scatter(i, 2)});
      if (i < 5) links.pairs.push_back({i, i + 1});
      for (std::size_t k = 0; k < 3; ++k) middle[k] += (joined.x[i][k] + joined.step * joined.v[i][k]) / count;
    }
    joined.scene.coupling.substeps = 1;
    joined.scene.add(links);
    const auto after = test::stepped<double>(joined, {.isa = isa}, 1);
    for (std::size_t k = 0; k < 3; ++k) {
      double mean = 0;
      for (std::size_t i = 0; i < count; ++i) mean += after[6 * i + k] / count;
      CHECK(std::abs(mean - middle[k]) <= 1e-12);
    }
  }
}

TEST_CASE("constraint: points and lines hold their particles") {
  Joined joined = under_gravity("beads", 9.81);
  joined.x = {{0, 0, 0}, {1, 1, 1}, {2, 0, 0}};
  joined.v = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}};
  joined.scene.add(OnPoint{.particle = 0, .at = {0.25, 0.5, 0}});
  joined.scene.add(OnLine{.particle = 1, .through = {1, 1, 1}, .direction = {0, 3, 4}});
  joined.scene.add(OnLine{.particle = 2, .through = {0, 0, 0}, .direction = {2, 0, 0}});
  const auto got = stepped<double>(joined, {.isa = best_isa()}, 60);
  for (std::size_t axis = 0; axis < 3; ++axis) CHECK(v(got, 0, axis) == 0);
  CHECK(x(got, 0, 0) == 0.25);
  CHECK(x(got, 0, 1) == 0.5);
  // The acceleration along the line is 0.6 g.
  const double along = -9.81 * 0.6 / 2;
  CHECK(std::abs(x(got, 1, 0) - 1) <= 1e-14);
  CHECK(std::abs(x(got, 1, 1) - (1 + 0.6 * along)) <= 1e-12);
  CHECK(std::abs(x(got, 1, 2) - (1 + 0.8 * along)) <= 1e-12);
  CHECK(x(got, 2, 0) == 2);
  CHECK(x(got, 2, 1) == 0);
}

TEST_CASE("constraint: a bad particle stays alone") {
  Joined joined = pendulum(1, 1, 9.81, 1.0 / 60);
  for (int k = 0; k < 4; ++k) {
    joined.x.push_back({5.0 + k, 0, 0});
    joined.v.push_back({0, 0, 0});
  }
  joined.scene.add(Distance{.pairs = {{2, 3}, {3, 4}, {4, 5}}, .length = 1.0});
  joined.scene.add(OnPoint{.particle = 3, .at = {0, 0, 0}});
  const auto wanted = stepped<double>(joined, {.isa = best_isa()}, 20);
  joined.v[3] = {not_a_number, 0, 0};
  joined.x[4] = {7, std::numeric_limits<double>::infinity(), 0};
  const auto got = stepped<double>(joined, {.isa = best_isa()}, 20);
  CHECK(std::equal(wanted.begin(), wanted.begin() + 12, got.begin()));
  for (const std::size_t i : {2U, 5U}) {
    for (std::size_t axis = 0; axis < 3; ++axis) CHECK(std::isfinite(x(got, i, axis)));
  }
  CHECK(std::isnan(x(got, 3, 0)));

  Joined torn = rope(20, 1);
  torn.x[10][2] = not_a_number;
  const auto halves = stepped<double>(torn, {.isa = best_isa()}, 60);
  double worst = 0;
  for (std::size_t i = 0; i < 20; ++i) {
    if (i != 9 && i != 10) worst = std::max(worst, std::abs(length(halves, i, i + 1) / 0.05 - 1));
  }
  CHECK(worst <= 1e-13);
}

TEST_CASE("constraint: pairs of two fixed ends do nothing, and pairs of coincident ends do no harm") {
  Joined joined = under_gravity("idle", 9.81);
  joined.x = {{0, 0, 0}, {1, 0, 0}, {2, 2, 2}, {2, 2, 2}};
  joined.v.resize(4);
  joined.scene.fixed = {0, 1};
  joined.scene.add(Distance{.pairs = {{0, 1}}, .length = 5.0});
  for (const Bound bound : {Bound::equal, Bound::at_most, Bound::at_least}) {
    Joined coincident = joined;
    coincident.scene.add(Distance{.pairs = {{2, 3}}, .length = 0.5, .bound = bound});
    const auto got = stepped<double>(coincident, {.isa = best_isa()}, 30);
    CHECK(x(got, 1, 0) == 1);
    for (const std::size_t i : {2U, 3U}) CHECK(std::abs(x(got, i, 1) - (2 - 9.81 / 8)) <= 1e-12);
  }
}

}  // namespace constrained::kept_test
