// No step ends with a particle inside a surface when springs or constraints act after the last flow.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "kernel/passes/joined_run.hpp"

namespace settling_test {

using namespace dvdx;
using test::Batch;
using test::Joined;
using test::Layout;
using test::Run;

constexpr double radius = 0.3;
constexpr Vec3 center{0.5, -0.35, 0.5};
constexpr double floor_at = -0.55;

// A sheet that falls onto a ball and a floor.
Joined falling() {
  Joined joined = test::sheet(12, 19, 400);
  joined.scene.fixed.clear();
  joined.scene.add(Sphere{.center = center, .radius = radius, .friction = 0.3});
  joined.scene.add(Plane{.offset = floor_at, .friction = 0.2});
  return joined;
}

std::vector<Joined> scenes() {
  std::vector<Joined> all;
  for (const SweepOrder sweeps : {SweepOrder::forward, SweepOrder::symmetric}) {
    Joined by_sweeps = falling();
    by_sweeps.scene.coupling = {.scheme = Scheme::sequential, .substeps = 2, .theta = 1, .sweeps = sweeps};
    all.push_back(by_sweeps);
    all.push_back(test::as_list(by_sweeps));
  }
  Joined held = falling();
  held.name += ", with constraints";
  Distance rods;
  for (std::uint32_t i = 0; i + 1 < 12 * 19; i += 3) rods.pairs.push_back({i, i + 1});
  rods.length = Scalars(0.04);
  held.scene.add(rods);
  all.push_back(held);
  held.scene.coupling = {.scheme = Scheme::sequential, .substeps = 6};
  all.push_back(held);
  return all;
}

// m: the depth of the deepest particle.
template <class T>
double depth(const State<T>& state) {
  double deepest = 0;
  for (std::size_t i = 0; i < state.count; ++i) {
    const auto x = [&](std::size_t axis) { return static_cast<double>(state.x[axis][i]); };
    const double r = std::hypot(x(0) - center[0], x(1) - center[1], x(2) - center[2]);
    deepest = std::max({deepest, radius - r, floor_at - x(1)});
  }
  return deepest;
}

TEST_CASE_TEMPLATE("settling: no particle ends a step inside a surface", T, float, double) {
  for (const Joined& joined : scenes()) {
    CAPTURE(joined.name);
    Batch<T> batch(Layout::soa, joined.x.size());
    test::place(joined, batch.view());
    const Plan<T> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
    double deepest = 0;
    for (int n = 0; n < 40; ++n) {
      REQUIRE(plan.step(batch.view()) == StepResult::done);
      deepest = std::max(deepest, depth(batch.view()));
    }
    CHECK(deepest < (sizeof(T) == 4 ? 3e-7 : 1e-12));
    CHECK(depth(batch.view()) > -1);  // no particle is lost
  }
}

TEST_CASE_TEMPLATE("settling: one call of many steps is many calls of one", T, float, double) {
  for (const Joined& joined : scenes()) {
    CAPTURE(joined.name);
    Batch<T> batch(Layout::soa, joined.x.size());
    test::place(joined, batch.view());
    const Plan<T> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
    for (int n = 0; n < 26; ++n) REQUIRE(plan.step(batch.view()) == StepResult::done);
    CHECK(test::difference(test::stepped<T>(joined, {.isa = best_isa()}, 26), test::values_of(batch.view())) == "");
  }
}

TEST_CASE_TEMPLATE("settling: the same bits on every instruction set", T, float, double) {
  std::size_t turn = sizeof(T) == 4 ? 0 : 1;  // separate and contracted take turns
  for (const Joined& joined : scenes()) {
    const Arithmetic arithmetic = turn++ % 2 == 0 ? Arithmetic::separate : Arithmetic::contracted;
    const std::vector<T> wanted = test::stepped<T>(joined, {.arithmetic = arithmetic}, 26);
    for (const Isa isa : available_isas(arithmetic)) {
      CAPTURE(joined.name);
      CAPTURE(name(isa));
      const std::vector<T> found = test::stepped<T>(joined, {.isa = isa, .arithmetic = arithmetic, .threads = 2}, 26);
      CHECK(test::difference(wanted, found) == "");
    }
  }
}

// Particles without contact stay unchanged: a floor far below changes nothing. (Without contacts sweeps count positions from
// the step's start.)
TEST_CASE_TEMPLATE("settling: a floor out of reach changes nothing of constrained particles", T, float, double) {
  for (Joined joined : scenes()) {
    if (joined.scene.constraints.empty()) continue;
    CAPTURE(joined.name);
    joined.scene.contacts.clear();
    const std::vector<T> wanted = test::stepped<T>(joined, {.isa = best_isa()}, 20);
    joined.scene.add(Plane{.offset = -50});
    const std::vector<T> found = test::stepped<T>(joined, {.isa = best_isa()}, 20);
    REQUIRE(wanted.size() == found.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) CHECK(wanted[i] == found[i]);
  }
}

}  // namespace settling_test
