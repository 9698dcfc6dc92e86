// Constraints have the scalar twins' bits on every instruction set, in every layout, on any number of threads.
#include <doctest/doctest.h>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "isa/passes.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/constrained.hpp"
#include "kernel/passes/every_run.hpp"
#include "kernel/passes/joined_run.hpp"
#include "plan/compiled_network.hpp"
#include "support/batch.hpp"

namespace constrained::bits_test {

using test::Batch;
using test::Layout;
using test::plan_of;
using test::Run;
using test::stepped;

// Particles in a loose heap.
Joined heap(std::size_t count) {
  Joined joined = under_gravity("heap", 9.81);
  for (std::size_t i = 0; i < count; ++i) {
    joined.x.push_back({test::scatter(i, 0), test::scatter(i, 1), test::scatter(i, 2)});
    joined.v.push_back({test::scatter(i, 3), test::scatter(i, 4), test::scatter(i, 5)});
  }
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

// Every kind by itself and with the others; chains of many lengths; fixed, held and shared particles, and individual masses.
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

  // Chains of 2 to 36 links: free, fixed at one end or at both, and some stretched so far that they only follow.
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

// Sixteen pairs whose pulses have summed to infinity. One end of each is at infinity, so that no pair acts again.
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
  Joined ropes = rope(links, 0.01 * links);  // cut by fixed particles into ropes of 100 links
  ropes.scene.fixed.clear();
  for (std::size_t i = 0; i < links; i += 100) ropes.scene.fixed.push_back(i);
  for (const auto& turn : {std::pair{many, 5U}, std::pair{ropes, 2U}}) {
    Joined joined = turn.first;
    const std::size_t threads = turn.second;
    joined.scene.coupling.substeps = 2;
    joined.scene.coupling.iterations = 2;  // the second sweep is like any later one
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

}  // namespace constrained::bits_test
