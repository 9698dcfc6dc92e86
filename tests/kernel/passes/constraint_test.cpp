// Constraints: the pendulum's closed form, order, what must be kept, bounds, and the scalar twins' bits.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "dvdx/constrain.hpp"
#include "dvdx/plan.hpp"
#include "isa/passes.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/every_run.hpp"
#include "kernel/passes/joined_run.hpp"
#include "plan/joints.hpp"
#include "support/batch.hpp"
#include "support/oracle.hpp"

namespace constraint_test {

using namespace dvdx;
using test::Batch;
using test::Joined;
using test::Layout;
using test::plan_of;
using test::Run;
using test::stepped;

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

// A bob flies until its string of 1 m is drawn, in the middle of the step: (0.5, -0.1) m with (5, 1) m/s reaches (1, 0) m. The
// string takes the 5 m/s away there, and 1 m/s goes on along the circle for the half of the step that is left.
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

// ---- bits --------------------------------------------------------------------------------------------------------------

// Particles in a loose heap.
Joined heap(std::size_t count) {
  Joined joined = under_gravity("heap", 9.81);
  for (std::size_t i = 0; i < count; ++i) {
    joined.x.push_back({test::scatter(i, 0), test::scatter(i, 1), test::scatter(i, 2)});
    joined.v.push_back({test::scatter(i, 3), test::scatter(i, 4), test::scatter(i, 5)});
  }
  return joined;
}

Joined rope(std::size_t links, double length, Bound bound = Bound::equal) {
  Joined joined = under_gravity("rope", 9.81);
  Distance distance{.pairs = {}, .length = length / static_cast<double>(links), .bound = bound};
  for (std::size_t i = 0; i <= links; ++i) {
    joined.x.push_back({length * static_cast<double>(i) / static_cast<double>(links), 0, 0});
    if (i != 0) distance.pairs.push_back({static_cast<std::uint32_t>(i - 1), static_cast<std::uint32_t>(i)});
  }
  joined.v.resize(links + 1);
  joined.scene.mass = 0.1 / static_cast<double>(links);
  joined.scene.add(distance);
  joined.scene.fixed = {0};
  return joined;
}

Distance random_pairs(std::uint32_t count, std::size_t pairs, std::size_t seed, Bound bound) {
  Distance distance{.pairs = {}, .length = std::nullopt, .bound = bound};
  for (std::size_t s = 0; s < pairs; ++s) {
    const auto i = static_cast<std::uint32_t>((count - 0.5) / 2 * (1 + test::scatter(seed + s, 0)));
    const auto j = static_cast<std::uint32_t>((count - 0.5) / 2 * (1 + test::scatter(seed + s, 1)));
    if (i != j) distance.pairs.push_back({i, j});
  }
  return distance;
}

// Every kind alone and beside the others; chains of many lengths; particles that are fixed, held, shared and of their own mass.
std::vector<Joined> bit_scenes() {
  std::vector<Joined> scenes;
  for (const Bound bound : {Bound::equal, Bound::at_most, Bound::at_least}) {
    Joined joined = heap(60);
    joined.name = "pairs anywhere, bound " + std::to_string(static_cast<int>(bound));
    joined.scene.add(random_pairs(60, 90, 7, bound));
    joined.scene.fixed = {3, 17};
    scenes.push_back(joined);
  }
  Joined all = heap(90);
  all.name = "all kinds";
  std::vector<double> masses;
  for (std::size_t i = 0; i < 90; ++i) masses.push_back(1.5 + test::scatter(i, 6));
  all.scene.mass = Scalars(masses);
  all.scene.add(random_pairs(90, 30, 1, Bound::equal));
  all.scene.add(random_pairs(90, 30, 2, Bound::at_most));
  all.scene.add(random_pairs(90, 30, 3, Bound::at_least));
  all.scene.add(OnPoint{.particle = 4, .at = {0.1, 0.2, 0.3}});
  for (std::uint32_t i = 10; i < 40; ++i) {
    all.scene.add(OnLine{.particle = i, .through = {0, 0.1, 0}, .direction = {test::scatter(i, 7), 1, test::scatter(i, 8)}});
  }
  all.scene.add(Plane{.normal = {0, 1, 0}, .offset = -1.1, .restitution = 0.2});
  all.scene.fixed = {0, 1, 89};
  scenes.push_back(all);

  // Chains of 2 to 36 links, some free, some fixed at an end or at both, some drawn out so far that they only follow.
  Joined chains = heap(0);
  chains.name = "chains";
  Distance links{.pairs = {}, .length = 0.05};
  for (std::uint32_t chain = 0; chain < 35; ++chain) {
    if (chain % 3 != 0) chains.scene.fixed.push_back(chains.x.size());
    const double drawn = chain % 5 == 4 ? 1.6 : 1;
    for (std::uint32_t k = 0; k <= chain + 2; ++k) {
      const auto i = static_cast<std::uint32_t>(chains.x.size());
      if (k != 0) links.pairs.push_back({i - 1, i});
      chains.x.push_back({0.05 * drawn * k, 0.2 * chain + 0.01 * test::scatter(i, 0), 0.01 * test::scatter(i, 1)});
      chains.v.push_back({test::scatter(i, 3), test::scatter(i, 4), 5 * test::scatter(i, 5)});
    }
    if (chain % 7 == 1) chains.scene.fixed.push_back(chains.x.size() - 1);
  }
  chains.scene.add(links);
  scenes.push_back(chains);
  Joined ring = heap(20);
  ring.name = "ring";
  Distance closed{.pairs = {{19, 0}}, .length = std::nullopt};
  for (std::uint32_t i = 1; i < 20; ++i) closed.pairs.push_back({i - 1, i});
  ring.scene.add(closed);
  scenes.push_back(ring);
  Joined sheet = test::sheet(9, 20, 50, 0.001);
  sheet.name = "a sheet that is not to stretch";
  Distance strain{.pairs = {}, .length = 0.056, .bound = Bound::at_most};
  for (std::uint32_t i = 1; i < 180; ++i) {
    if (i % 20 != 0) strain.pairs.push_back({i - 1, i});
  }
  sheet.scene.add(strain);
  scenes.push_back(sheet);
  return scenes;
}

template <class T>
void check_bits(const Joined& joined, Arithmetic arithmetic) {
  const std::vector<T> wanted = stepped<T>(joined, {.arithmetic = arithmetic}, 7);
  std::size_t turn = 0;
  for (const Isa isa : available_isas(arithmetic)) {
    const Run run{.isa = isa, .arithmetic = arithmetic, .layout = test::layouts[turn++ % test::layouts.size()]};
    const std::string difference = test::difference(wanted, stepped<T>(joined, run, 7));
    CHECK_MESSAGE(difference.empty(),
                  joined.name << ", " << 8 * sizeof(T) << " bits, " << std::string(name(isa)) << ": " << difference);
  }
}

TEST_CASE_TEMPLATE("constraint: every ISA and layout gives the scalar reference's bits", T, float, double) {
  for (Joined& joined : bit_scenes()) {
    check_bits<T>(joined, Arithmetic::separate);
    check_bits<T>(joined, Arithmetic::contracted);
    joined.step = -joined.step;
    joined.scene.coupling.substeps = 6;
    joined.scene.coupling.iterations = 2;
    check_bits<T>(joined, Arithmetic::separate);
  }
}

// Sixteen pairs whose pulses have summed to infinity. One end has left for infinity at that, so that none of them acts again.
template <class T>
struct Overflown {
  static constexpr std::size_t pairs = 16;
  static constexpr T infinite = std::numeric_limits<T>::infinity();

  std::vector<std::vector<T>> columns = std::vector<std::vector<T>>(3, std::vector<T>(2 * pairs, T(1)));
  std::vector<T> ones = std::vector<T>(pairs, T(1)), halves = std::vector<T>(pairs, T(0.5)), rate = ones;
  std::vector<T> sums;
  std::vector<std::int32_t> a, b;
  Axes<T> axes{columns[0].data(), columns[1].data(), columns[2].data()};
  PairTerms<T> terms;

  explicit Overflown(T sum) : sums(pairs, sum) {
    for (std::size_t k = 0; k < pairs; ++k) {
      a.push_back(static_cast<std::int32_t>(k));
      b.push_back(static_cast<std::int32_t>(pairs + k));
      for (std::vector<T>& column : columns) column[pairs + k] = infinite;
    }
    terms.a = a.data();
    terms.b = b.data();
    terms.l = ones.data();
    terms.share_a = terms.share_b = halves.data();
    terms.n = {ones.data(), ones.data(), ones.data()};
    terms.s = terms.m = sums.data();
    terms.inverse = ones.data();
    terms.rate = rate.data();
    terms.per_step = T(1);
  }
  Overflown(const Overflown&) = delete;
  Overflown& operator=(const Overflown&) = delete;

  [[nodiscard]] bool is_as_it_was(T sum) const {
    const Overflown before(sum);
    return columns == before.columns && sums == before.sums;
  }
};

TEST_CASE_TEMPLATE("constraint: sums of pulses that are infinite push no bad particle further, on every instruction set", T,
                   float, double) {
  test::for_each_run([](const Run& run, const std::string& words) {
    const auto& kernels = find_passes(run.isa, run.arithmetic)->template of<T>().constraint;
    for (const Bound bound : {Bound::at_most, Bound::at_least}) {
      const T sum = bound == Bound::at_most ? -Overflown<T>::infinite : Overflown<T>::infinite;
      Overflown<T> placed(sum), turned(sum), crossing(sum);
      kernels.solve_pair_positions(placed.terms, bound, Round::again, placed.axes, 0, placed.pairs);
      CHECK_MESSAGE(placed.is_as_it_was(sum), words);
      kernels.solve_pair_velocities(turned.terms, bound, Time::forwards, Round::again, turned.axes, 0, turned.pairs);
      CHECK_MESSAGE(turned.is_as_it_was(sum), words);
      kernels.solve_crossing_velocities(crossing.terms, Time::forwards, crossing.axes, 0, crossing.pairs);
      CHECK_MESSAGE(crossing.is_as_it_was(sum), words);
    }
  });
}

TEST_CASE("constraint: beside springs in every scheme, the scalar reference's bits") {
  for (const Coupling& coupling :
       {Coupling{.scheme = Scheme::fourth_order}, Coupling{.scheme = Scheme::sequential, .substeps = 3},
        Coupling{.scheme = Scheme::sequential, .substeps = 3, .theta = 1, .sweeps = SweepOrder::forward},
        Coupling{.scheme = Scheme::accumulate}}) {
    Joined joined = bit_scenes().back();
    joined.scene.coupling = coupling;
    check_bits<float>(joined, Arithmetic::separate);
    check_bits<double>(joined, Arithmetic::contracted);
  }
}

TEST_CASE("constraint: any number of threads gives the same bits, many particles" * doctest::test_suite("threads")) {
  Joined many = heap(parallel_from);
  many.scene.add(random_pairs(parallel_from, 12000, 5, Bound::equal));
  many.scene.add(random_pairs(parallel_from, 6000, 6, Bound::at_most));
  many.scene.fixed = {3, 4, 5};
  constexpr std::size_t links = parallel_from;
  Joined ropes = rope(links, 0.01 * links);  // of 100 links each, cut by what is fixed
  ropes.scene.fixed.clear();
  for (std::size_t i = 0; i < links; i += 100) ropes.scene.fixed.push_back(i);
  for (const auto& turn : {std::pair{many, 5U}, std::pair{ropes, 2U}}) {
    Joined joined = turn.first;
    const std::size_t threads = turn.second;
    joined.scene.coupling.substeps = 2;
    joined.scene.coupling.iterations = 2;  // the second sweep is as any later one
    const auto plan = plan_of<float>(joined, {.isa = best_isa()});
    const std::string difference =
        test::difference(stepped(joined, plan, {}, 1), stepped(joined, plan, {.threads = threads}, 1));
    CHECK_MESSAGE(difference.empty(), joined.name << ", threads " << threads << ": " << difference);
  }
}

TEST_CASE("constraint: one call of five steps is five calls of one") {
  for (const Joined& joined : bit_scenes()) {
    Batch<float> batch(Layout::aos, joined.x.size());
    test::place(joined, batch.view());
    const Plan<float> plan = plan_of(joined, {.isa = best_isa()}, batch.view());
    for (int step = 0; step < 5; ++step) REQUIRE(plan.step(batch.view(), 1) == StepResult::done);
    CHECK_MESSAGE(test::difference(stepped<float>(joined, {.isa = best_isa()}, 5), test::values_of(batch.view())) == "",
                  joined.name);
  }
}

// ---- invariants --------------------------------------------------------------------------------------------------------

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
  // The rod turns in the plane of its axis and the ends' difference of velocity.
  const double spin = (x(got, 1, 0) - x(got, 0, 0)) * (v(got, 1, 1) - v(got, 0, 1)) -
                      (x(got, 1, 1) - x(got, 0, 1)) * (v(got, 1, 0) - v(got, 0, 0));
  CHECK(std::abs(spin / 6 - 1) <= 1e-11);
  CHECK(std::abs(length(got, 0, 1) - 1) <= 1e-14);
}

TEST_CASE("constraint: a rope of 100 links keeps its lengths and its energy") {
  const Joined coarse = rope(100, 1);  // far fewer sub-steps than its fast motion has: nothing but the lengths is right
  const Joined fine = with_substeps(coarse, 64);
  const double depth = 0.1 * 9.81;  // J: what the energy is judged by
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
  // A double pendulum, and the same with a rod to nearly nothing at its joint, which makes the other two single.
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

TEST_CASE("constraint: what is to keep off does so, and bounces not") {
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

TEST_CASE("constraint: a step back of what moves the other way mirrors a step forwards, for every bound") {
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
  // Down the line: g 0.6 along it.
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

TEST_CASE("constraint: pairs of two fixed ends and of ends that coincide do nothing, or nothing bad") {
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

// ---- of your own -------------------------------------------------------------------------------------------------------

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

TEST_CASE_TEMPLATE("constraint of your own: two make a curve, in any layout, and a bad particle stays alone", T, float,
                   double) {
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

}  // namespace constraint_test
