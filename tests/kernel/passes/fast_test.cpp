// Fast arithmetic: inverse roots from the machine's own estimate. Only bounds restrict its bits, which must not depend on
// threads, blocks, layouts and calls.
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
#include "isa/passes.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/batch.hpp"
#include "support/isas.hpp"

namespace fast_test {

using namespace dvdx;
using test::Batch;
using test::Joined;
using test::Layout;
using test::Run;
using test::stepped;

constexpr double most_ulps = 1.2;  // derived in estimates.inl.hpp

// Makes one spring's force on a particle at the origin d/r of the particle 16 further on: k - kl/r with k = 0 and kl = -1.
template <class T>
struct Directions {
  std::vector<T> memory = std::vector<T>(std::size_t{15} * slice, T(0));
  std::array<std::uint32_t, 2> first_slot{0, 1};
  Slot slot{.offset = slice, .indices = -1};
  GraphTerms<T> graph;
  WorkColumns<T> work;

  Directions() {
    const auto column = [this](std::size_t n) { return memory.data() + n * slice; };
    for (std::size_t axis = 0; axis < 3; ++axis) {
      work.x[axis] = column(2 * axis);
      work.v[axis] = column(6 + axis);
      work.v_next[axis] = column(9 + axis);
    }
    std::fill_n(column(12), slice, T(1));
    std::fill_n(column(13), slice, T(-1));
    work.w = column(12);
    // k is 0. A nonzero c makes the scalar twin count the spring.
    graph = {.first_slot = first_slot.data(),
             .slots = &slot,
             .indices = nullptr,
             .k = column(14),
             .kl = column(13),
             .c = column(12)};
  }

  void set(std::size_t lane, const std::array<T, 3>& d) {
    for (std::size_t axis = 0; axis < 3; ++axis) work.x[axis][slice + lane] = d[axis];
  }
  void pull(const Passes& passes) { passes.of<T>().network.graph(graph, work, T(1), 0, 1); }
  [[nodiscard]] T pulled(std::size_t lane, std::size_t axis) const { return work.v_next[axis][lane]; }
};

template <class T>
T random_from_1_to_2(std::uint64_t& state) {
  state = state * 6364136223846793005U + 1442695040888963407U;
  return static_cast<T>(1 + static_cast<double>(state >> 12) * 0x1p-52);
}

// The worst error of 1/sqrt(x) in units of the last place, over all exponents of r and random mantissas. With d = (r, p, 0) and
// p a power of two, the force's second component is p/r, exact except for the root.
template <class T>
double worst_ulps(const Passes& passes) {
  const int widest = sizeof(T) == 4 ? 49 : 464;
  std::uint64_t state = 1;
  Directions<T> directions;
  double worst = 0;
  for (int exponent = -widest; exponent < widest; ++exponent) {
    for (std::size_t n = 0; n < (sizeof(T) == 4 ? 256 : 32); ++n) {
      std::array<T, slice> r{};
      const T p = std::ldexp(T(1), exponent - 2);
      for (std::size_t lane = 0; lane < slice; ++lane) {
        r[lane] = std::ldexp(random_from_1_to_2<T>(state), exponent);
        directions.set(lane, {r[lane], p, 0});
      }
      directions.pull(passes);
      for (std::size_t lane = 0; lane < slice; ++lane) {
        const T square = std::fma(p, p, r[lane] * r[lane]);
        const long double wanted = 1 / std::sqrt(static_cast<long double>(square));
        const T got = directions.pulled(lane, 1) / p;
        const long double ulp = std::ldexp(1.0L, std::ilogb(wanted) - (std::numeric_limits<T>::digits - 1));
        worst = std::max(worst, static_cast<double>(std::abs(static_cast<long double>(got) - wanted) / ulp));
      }
    }
  }
  return worst;
}

constexpr std::array all_schemes = {
    Coupling{.scheme = Scheme::leapfrog},
    Coupling{.scheme = Scheme::fourth_order},
    Coupling{.scheme = Scheme::sequential, .substeps = 3, .theta = 0.5},
    Coupling{.scheme = Scheme::accumulate, .method = Method::combined},
};

Joined with(Joined joined, const Coupling& coupling) {
  joined.scene.coupling = coupling;
  return joined;
}

double difference_rms(const std::vector<float>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); i += 6) {
    for (std::size_t axis = 0; axis < 3; ++axis) sum += std::pow(static_cast<double>(a[i + axis]) - b[i + axis], 2);
  }
  return std::sqrt(sum / static_cast<double>(a.size() / 6));
}

TEST_CASE_TEMPLATE("fast: an inverse root is within 1.2 units in the last place, whatever its exponent", T, float, double) {
  for (const Arithmetic arithmetic : {Arithmetic::contracted, Arithmetic::fast}) {
    for (const Isa isa : available_isas(arithmetic)) {
      const double worst = worst_ulps<T>(*find_passes(isa, arithmetic));
      MESSAGE(name(isa) << " " << name(arithmetic) << ", " << 8 * sizeof(T) << " bits: at most " << worst << " ulp");
      CHECK(worst < most_ulps);
      CHECK(worst > 0.5);  // the result is not the correctly rounded root
    }
  }
}

TEST_CASE_TEMPLATE("fast: a direction that has no length or is not finite pulls at nothing, as in separate arithmetic", T,
                   float, double) {
  constexpr T infinite = std::numeric_limits<T>::infinity();
  constexpr T nan = std::numeric_limits<T>::quiet_NaN();
  constexpr T least = std::numeric_limits<T>::min();
  const std::vector<std::array<T, 3>> bad = {{0, 0, 0},
                                             {-T(0), 0, -T(0)},
                                             {least, 0, 0},
                                             {0, std::numeric_limits<T>::denorm_min(), 0},
                                             {std::sqrt(least_square<T>) / 2, 0, 0},
                                             {std::sqrt(most_square<T>) * 2, 0, 0},
                                             {std::numeric_limits<T>::max(), 0, 1},
                                             {infinite, 0, 0},
                                             {1, -infinite, infinite},
                                             {nan, 1, 1},
                                             {0, 0, nan}};
  for (const Isa isa : available_isas(Arithmetic::fast)) {
    Directions<T> directions;
    for (std::size_t lane = 0; lane < slice; ++lane)
      directions.set(lane, lane < bad.size() ? bad[lane] : std::array<T, 3>{0, 3, 4});
    directions.pull(*find_passes(isa, Arithmetic::fast));
    for (std::size_t lane = 0; lane < bad.size(); ++lane) {
      for (std::size_t axis = 0; axis < 3; ++axis) CHECK(directions.pulled(lane, axis) == 0);
    }
    for (std::size_t lane = bad.size(); lane < slice; ++lane) {
      CHECK(std::abs(directions.pulled(lane, 1) - T(0.6)) <= std::numeric_limits<T>::epsilon());
      CHECK(std::abs(directions.pulled(lane, 2) - T(0.8)) <= std::numeric_limits<T>::epsilon());
    }
  }
}

// One kick of particles at rest, compared with the sum of k (1 - l/r) d over the springs in long double, up to rounding.
TEST_CASE("fast: the pulse of a grid and of its list is the springs' force to a few roundings of its terms") {
  Joined sheet = test::sheet(19, 37, 50);
  sheet.scene.forces.clear();
  for (auto& v : sheet.v) v = {};
  sheet.step = 1e-3;
  sheet.scene.coupling = {.scheme = Scheme::leapfrog, .substeps = 1};
  const Springs springs = springs_of(std::get<Grid>(sheet.scene.networks[0]));
  const auto count = sheet.x.size();
  std::vector<std::array<double, 3>> force(count), scale(count);
  for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
    const auto [i, j] = springs.pairs[s];
    std::array<long double, 3> d{};
    long double square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      d[axis] = static_cast<long double>(static_cast<float>(sheet.x[j][axis])) - static_cast<float>(sheet.x[i][axis]);
      square += d[axis] * d[axis];
    }
    const double k = springs.stiffness[s];
    const double l = (*springs.rest_length)[s];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto F = static_cast<double>(k * (1 - l / std::sqrt(square)) * d[axis]);
      force[i][axis] += F;
      force[j][axis] -= F;
      for (const auto end : {i, j}) scale[end][axis] += k * static_cast<double>(std::abs(d[axis]));
    }
  }
  const double w = static_cast<double>(count) / 0.3;
  for (const Joined& joined : {sheet, test::as_list(sheet)}) {
    for (const Isa isa : available_isas(Arithmetic::fast)) {
      const auto got = stepped<float>(joined, {.isa = isa, .arithmetic = Arithmetic::fast}, 1);
      double worst = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const auto& fixed = sheet.scene.fixed;
        if (std::find(fixed.begin(), fixed.end(), i) != fixed.end()) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double wanted = w * sheet.step * force[i][axis];
          const double rounding = w * sheet.step * scale[i][axis] * 0x1p-24;
          worst = std::max(worst, std::abs(static_cast<double>(got[6 * i + 3 + axis]) - wanted) / rounding);
        }
      }
      MESSAGE(joined.name << ", " << name(isa) << ": at most " << worst << " roundings");
      CHECK(worst < 3);
      CHECK(worst > 0);
    }
  }
}

TEST_CASE("fast: threads, blocks, layouts and calls do not change the bits, in any scheme") {
  const Joined small = test::sheet(9, 20, 50, 0.001);
  Joined large = test::sheet(140, 150, 5);
  large.step = 1.0 / 2000;
  for (const Isa isa : available_isas(Arithmetic::fast)) {
    for (const Coupling& coupling : all_schemes) {
      for (const Joined& sheet : {small, test::as_list(small)}) {
        const Joined joined = with(sheet, coupling);
        const auto wanted = stepped<float>(joined, {.isa = isa, .arithmetic = Arithmetic::fast}, 4);
        for (const Layout layout : test::layouts) {
          const Run run{.isa = isa, .arithmetic = Arithmetic::fast, .layout = layout};
          CHECK(test::difference(wanted, stepped<float>(joined, run, 4)) == "");
        }
        for (const std::size_t block : {std::size_t{16}, std::size_t{1024}}) {
          Batch<float> batch(Layout::soa, joined.x.size());
          test::place(joined, batch.view());
          const Options options{.step = joined.step, .isa = isa, .arithmetic = Arithmetic::fast, .block = block};
          const auto plan = compile<float>(joined.scene, options, batch.view());
          REQUIRE(plan.has_value());
          for (int step = 0; step < 4; ++step) REQUIRE(plan->step(batch.view(), 1) == StepResult::done);
          CHECK(test::difference(wanted, test::values_of(batch.view())) == "");
        }
      }
      if (isa == Isa::reference) continue;
      const Joined joined = with(large, coupling);
      const auto wanted = stepped<float>(joined, {.isa = isa, .arithmetic = Arithmetic::fast}, 1);
      for (const std::size_t threads : {2U, 3U, 4U}) {
        const Run run{.isa = isa, .arithmetic = Arithmetic::fast, .threads = threads};
        CHECK(test::difference(wanted, stepped<float>(joined, run, 1)) == "");
      }
    }
  }
}

TEST_CASE("fast: a grid and the list of its springs give the same bits where particles sum their springs") {
  for (const Isa isa : available_isas(Arithmetic::fast)) {
    const Run run{.isa = isa, .arithmetic = Arithmetic::fast};
    for (const Scheme scheme : {Scheme::leapfrog, Scheme::fourth_order}) {
      const Joined grid = with(test::sheet(17, 33, 50), {.scheme = scheme, .substeps = 40});
      CHECK(test::difference(stepped<float>(grid, run, 2), stepped<float>(test::as_list(grid), run, 2)) == "");
      CHECK(test::difference(stepped<double>(grid, run, 2), stepped<double>(test::as_list(grid), run, 2)) == "");
    }
  }
}

TEST_CASE("fast: over a run the error grows as in separate arithmetic") {
  for (const Coupling& coupling : all_schemes) {
    const Joined joined = with(test::sheet(16, 16, 50), coupling);
    const auto truth = stepped<double>(joined, {}, 24);
    const double separate = difference_rms(stepped<float>(joined, {.isa = best_isa()}, 24), truth);
    for (const Isa isa : available_isas(Arithmetic::fast)) {
      const double fast = difference_rms(stepped<float>(joined, {.isa = isa, .arithmetic = Arithmetic::fast}, 24), truth);
      MESSAGE("scheme " << static_cast<int>(coupling.scheme) << ", " << name(isa) << ": " << fast << " m, separate "
                        << separate);
      CHECK(fast < 4 * separate);  // rounding, which a sheet amplifies: another machine has other bits
    }
  }
}

TEST_CASE("fast: a particle that is not a number stays alone") {
  constexpr std::size_t bad = 77;
  for (const bool is_list : {false, true}) {
    Joined joined = with(test::sheet(12, 20, 50), {.scheme = Scheme::leapfrog});
    if (is_list) joined = test::as_list(joined);
    const auto start = [&](State<float>& state) {
      test::place(joined, state);
      state.x[1][bad] = std::numeric_limits<float>::quiet_NaN();
    };
    for (const Isa isa : available_isas(Arithmetic::fast)) {
      Batch<float> good(Layout::soa, joined.x.size());
      test::place(joined, good.view());
      const auto plan = test::plan_of(joined, {.isa = isa, .arithmetic = Arithmetic::fast}, good.view());
      Batch<float> batch(Layout::soa, joined.x.size());
      start(batch.view());
      REQUIRE(plan.step(batch.view(), 5) == StepResult::done);
      const auto values = test::values_of(batch.view());
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (i / 6 != bad) CHECK(std::isfinite(values[i]));
      }
      CHECK(std::isnan(values[6 * bad + 1]));
    }
  }
}

TEST_CASE("fast: the reference's table is the contracted one, and others have their own springs alone") {
  CHECK(find_passes(Isa::reference, Arithmetic::fast) == find_passes(Isa::reference, Arithmetic::contracted));
  if (!test::has_several_isas(Arithmetic::fast)) return;
  for (const Isa isa : available_isas(Arithmetic::fast)) {
    if (isa == Isa::reference) continue;
    const Passes* fast = find_passes(isa, Arithmetic::fast);
    const Passes* contracted = find_passes(isa, Arithmetic::contracted);
    CHECK((fast->f32.network.grid != contracted->f32.network.grid));
    CHECK((fast->f32.network.graph != contracted->f32.network.graph));
    CHECK((fast->f32.free.step == contracted->f32.free.step));
    CHECK((fast->f64.free.step == contracted->f64.free.step));
    CHECK((fast->f64.network.grid == contracted->f64.network.grid) == (isa == Isa::avx2));  // AVX2 estimates float32 only
  }
}

}  // namespace fast_test
