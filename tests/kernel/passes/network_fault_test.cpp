// Networks with bad particles, coincident ends and fixed particles: no fault spreads.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "kernel/passes/networks.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"

namespace networks::fault_test {

using test::is_close;
using test::Run;
using test::stepped;

TEST_CASE("network: a bad particle stays alone, its neighbours go on without its springs") {
  for (const bool is_list : {false, true}) {
    for (const Coupling& coupling : all_schemes) {
      Joined joined = with(test::sheet(32, 32, 50, 0.001), coupling);
      if (is_list) joined = test::as_list(joined);
      joined.x[500][1] = std::numeric_limits<double>::quiet_NaN();
      joined.v[77][2] = std::numeric_limits<double>::infinity();
      const auto got = as_double(stepped<float>(joined, {.isa = best_isa()}, 10));
      std::size_t bad = 0;
      for (std::size_t i = 0; i < 1024; ++i) {
        bool is_bad = false;
        for (std::size_t k = 0; k < 6; ++k) is_bad = is_bad || !std::isfinite(got[6 * i + k]);
        bad += is_bad ? 1 : 0;
      }
      CHECK_MESSAGE(bad == 2, "scheme " << static_cast<int>(coupling.scheme) << (is_list ? ", list" : ", grid"));
    }
  }
}

constexpr std::size_t half = 63;  // particles in each of two separate sheets

Joined two_sheets() {
  Joined joined = test::sheet(7, 9, 50, 0.001);
  Grid second = std::get<Grid>(joined.scene.networks[0]);
  second.first = half;
  joined.scene.add(Network(second));
  for (std::size_t i = 0; i < half; ++i) {
    joined.x.push_back({joined.x[i][0], joined.x[i][1] + 1, joined.x[i][2]});
    joined.v.push_back(joined.v[i]);
  }
  return joined;
}

Joined two_lists() {
  Joined joined = two_sheets();
  for (Network& network : joined.scene.networks) network = springs_of(std::get<Grid>(network));
  joined.name += ", as lists";
  return joined;
}

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();

// Makes a particle of either sheet bad in one of four ways, depending on the turn.
template <class T>
void check_other_sheet(const Joined& joined, const test::Run& run, const std::vector<T>& wanted, std::size_t turn) {
  constexpr std::array<std::array<double, 2>, 4> ways{
      {{not_a_number, 0.0}, {0.0, not_a_number}, {infinite, 1.0}, {1.0, -infinite}}};
  const auto& [bad_x, bad_v] = ways[turn % 4];
  const std::size_t bad = turn / 4 % 2 == 0 ? std::size_t{31} : half + 31;
  Joined ill = joined;
  ill.x[bad][1] = bad_x;
  ill.v[bad][0] = bad_v;
  std::vector<T> got = stepped<T>(ill, run, 4);
  const auto own = static_cast<std::ptrdiff_t>(bad < half ? 0 : 6 * half);
  std::copy_n(wanted.begin() + own, 6 * half, got.begin() + own);
  const std::string difference = test::difference(wanted, got);
  CHECK_MESSAGE(difference.empty(), joined.name << ", scheme " << static_cast<int>(joined.scene.coupling.scheme) << ", "
                                                << name(run.isa) << ", " << name(run.arithmetic) << ": " << difference);
}

// Removes the springs of one particle.
Joined without_springs_of(Joined joined, std::uint32_t particle) {
  for (Network& network : joined.scene.networks) {
    auto& springs = std::get<Springs>(network);
    Springs left{.pairs = {}, .stiffness = 0.0, .rest_length = std::nullopt, .damping = springs.damping};
    std::vector<double> k;
    std::vector<double> l;
    for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
      if (springs.pairs[s][0] == particle || springs.pairs[s][1] == particle) continue;
      left.pairs.push_back(springs.pairs[s]);
      k.push_back(springs.stiffness[s]);
      l.push_back((*springs.rest_length)[s]);
    }
    left.stiffness = Scalars(k);
    left.rest_length = Scalars(l);
    springs = left;
  }
  return joined;
}

TEST_CASE_TEMPLATE("network: a bad particle changes no bit of a sheet that is not joined with it, in any scheme", T, float,
                   double) {
  std::size_t first = 0;  // over all schemes, every ISA meets every way in either sheet
  for (const Joined& two : {two_sheets(), two_lists()}) {
    for (const Coupling& coupling : all_schemes) {
      const Joined joined = with(two, coupling);
      std::size_t turn = first++;
      for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted, Arithmetic::fast}) {
        std::vector<T> wanted;
        for (const Isa isa : available_isas(arithmetic)) {
          const Run run{.isa = isa, .arithmetic = arithmetic};
          // only fast arithmetic has different bits on another ISA
          if (wanted.empty() || arithmetic == Arithmetic::fast) wanted = stepped<T>(joined, run, 4);
          check_other_sheet<T>(joined, run, wanted, turn++);
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("network: neighbours of a bad particle go on as if its springs were cut, bit by bit", T, float, double) {
  constexpr std::size_t bad = 31;
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order, Scheme::accumulate}) {
    Joined joined = with(two_lists(), {.scheme = scheme, .substeps = 12});
    for (const Isa isa : available_isas()) {
      const std::vector<T> wanted = stepped<T>(without_springs_of(joined, bad), {.isa = isa}, 4);
      Joined ill = joined;
      ill.x[bad][1] = not_a_number;
      std::vector<T> got = stepped<T>(ill, {.isa = isa}, 4);
      std::copy_n(wanted.begin() + 6 * bad, 6, got.begin() + 6 * bad);
      const std::string difference = test::difference(wanted, got);
      CHECK_MESSAGE(difference.empty(), "scheme " << static_cast<int>(scheme) << ", " << name(isa) << ": " << difference);
    }
  }
}

TEST_CASE("network: coincident ends contribute nothing, and ends that pass through each other stay finite") {
  for (const Coupling& coupling : all_schemes) {
    Joined still = with(on_a_line({0.5, 0.5}, {0.25, 0.25}, 0), coupling);
    still.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 100.0, .rest_length = 1.0}));
    const auto got = stepped<double>(still, {.isa = best_isa()}, 60);
    CHECK(is_close(x(got, 0, 0), 0.75, 1e-12));
    CHECK(x(got, 1, 0) == x(got, 0, 0));

    Joined through = with(on_a_line({0, 1}, {1, -1}, 0), coupling);
    through.scene.add(Network(Springs{.pairs = {{0, 1}}, .stiffness = 100.0, .rest_length = 0.0}));
    const auto passed = stepped<double>(through, {.isa = best_isa()}, 120);
    for (const double value : passed) CHECK(std::isfinite(value));
    CHECK(std::abs(v(passed, 0, 0) + v(passed, 1, 0)) < 1e-12);
  }
}

TEST_CASE("network: fixed particles do not move by a bit, and springs between them do nothing") {
  for (const Coupling& coupling : all_schemes) {
    Joined joined = with(test::sheet(6, 9, 50), coupling);
    joined.scene.fixed = {0, 1, 2, 10, 53};
    joined.v[1] = {3, -0.0, 5};
    const auto start = stepped<float>(joined, {.isa = best_isa()}, 0);
    const auto got = stepped<float>(joined, {.isa = best_isa()}, 20);
    for (const std::size_t i : joined.scene.fixed) {
      for (std::size_t k = 0; k < 6; ++k)
        CHECK(std::bit_cast<std::uint32_t>(start[6 * i + k]) == std::bit_cast<std::uint32_t>(got[6 * i + k]));
    }
  }
}

}  // namespace networks::fault_test
