// Plan::check: stretch, rods, energy and non-finite values, compared with sums over all pairs.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"

namespace state_check_test {

using namespace dvdx;
using test::Batch;
using test::Joined;
using test::Layout;

template <class T>
double distance(const State<T>& state, const Pair& ends) {
  double square = 0;
  for (const Column<T>& x : state.x) {
    const double d = static_cast<double>(x[ends[1]]) - static_cast<double>(x[ends[0]]);
    square += d * d;
  }
  return std::sqrt(square);
}

bool are_same(const Pair& a, const Pair& b) { return a == b || a == Pair{b[1], b[0]}; }

// The check spring by spring, in the scene's order.
template <class T>
StateCheck by_springs(const Scene& scene, const State<T>& state) {
  StateCheck found;
  for (std::size_t n = 0; n < scene.networks.size(); ++n) {
    const auto* grid = std::get_if<Grid>(&scene.networks[n]);
    const Springs springs = grid != nullptr ? springs_of(*grid) : std::get<Springs>(scene.networks[n]);
    const std::vector<Pair>& torn = grid != nullptr ? grid->broken : springs.broken;
    for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
      const Pair& ends = springs.pairs[s];
      if (std::any_of(torn.begin(), torn.end(), [&](const Pair& other) { return are_same(other, ends); })) continue;
      const double r = distance(state, ends);
      const double l = (*springs.rest_length)[s];
      found.elastic += 0.5 * springs.stiffness[s] * (r - l) * (r - l);
      if (!(springs.stiffness[s] > 0 && l > 0 && r / l > found.stretch)) continue;
      found.stretch = r / l;
      found.network = n;
      found.spring = {std::min(ends[0], ends[1]), std::max(ends[0], ends[1])};
    }
  }
  for (std::size_t i = 0; i < state.count; ++i) {
    if (std::find(scene.fixed.begin(), scene.fixed.end(), i) != scene.fixed.end()) continue;
    for (const Column<T>& v : state.v) found.kinetic += 0.5 * scene.mass[i] * std::pow(static_cast<double>(v[i]), 2);
    found.weight += 9.81 * scene.mass[i] * static_cast<double>(state.x[1][i]);
  }
  return found;
}

void check_alike(const StateCheck& found, const StateCheck& wanted, double rounding) {
  CHECK(found.result == StepResult::done);
  CHECK(found.stretch == doctest::Approx(wanted.stretch).epsilon(rounding));
  CHECK(found.network == wanted.network);
  CHECK(found.spring == wanted.spring);
  CHECK(found.elastic == doctest::Approx(wanted.elastic).epsilon(100 * rounding));
  CHECK(found.kinetic == doctest::Approx(wanted.kinetic).epsilon(rounding));
  CHECK(found.weight == doctest::Approx(wanted.weight).epsilon(100 * rounding));
  CHECK(found.not_finite == 0);
}

template <class T>
void check_layouts(const Joined& joined) {
  const double rounding = 64 * double{std::numeric_limits<T>::epsilon()};
  for (const Layout layout : {Layout::soa, Layout::aos, Layout::aosoa8}) {
    CAPTURE(joined.name);
    CAPTURE(name(layout));
    Batch<T> batch(layout, joined.x.size());
    test::place(joined, batch.view());
    const Plan<T> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
    check_alike(plan.check(batch.view()), by_springs(joined.scene, batch.view()), rounding);
    REQUIRE(plan.step(batch.view(), 12) == StepResult::done);
    check_alike(plan.check(batch.view()), by_springs(joined.scene, batch.view()), rounding);
    CHECK(batch.is_clean());
  }
}

TEST_CASE("check: a sheet's stretch and energy are those of its springs one by one, in any layout, type and form") {
  for (const std::size_t columns : {7U, 12U, 64U}) {
    Joined sheet = test::sheet(columns == 64 ? 3 : 9, columns, 200);
    std::get<Grid>(sheet.scene.networks[0]).bend = 20;
    check_layouts<double>(sheet);
    check_layouts<float>(sheet);
    check_layouts<double>(test::as_list(sheet));
    check_layouts<float>(test::as_list(sheet));
  }
  Joined masses = test::sheet(9, 12, 200);
  masses.scene.mass.make_each(masses.x.size());
  for (std::size_t i = 0; i < masses.x.size(); ++i) masses.scene.mass.set(i, 0.002 + 1e-5 * static_cast<double>(i));
  check_layouts<double>(masses);
}

TEST_CASE("check: torn springs do not count, those torn later neither, in grids and lists, in place and with a clone") {
  for (const bool is_grid : {true, false}) {
    Joined joined = test::sheet(9, 12, 200);
    if (!is_grid) joined = test::as_list(joined);
    std::visit([](auto& network) { network.broken = {{14, 13}, {40, 52}}; }, joined.scene.networks[0]);
    Batch<double> batch(Layout::soa, joined.x.size());
    test::place(joined, batch.view());
    Plan<double> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
    const auto worst = [&] {
      const StateCheck found = plan.check(batch.view());
      check_alike(found, by_springs(plan.scene(), batch.view()), 1e-12);
      return found;
    };
    batch.view().x[1][13] += 40;
    for (int k = 0; k < 3; ++k) REQUIRE(plan.break_spring(0, worst().spring).has_value());
    const Plan<double> clone = plan.clone();
    REQUIRE(plan.break_spring(0, worst().spring).has_value());
    CHECK(clone.check(batch.view()).stretch > worst().stretch);
    REQUIRE(plan.tear(0, 1.5, batch.view()).value() > 0);
    CHECK(worst().stretch <= 1.5);
  }
}

// Two particles of 2 and 4 kg, 3 m apart, joined by a spring of 1 m and a rod of 2 m, with speeds of 1 and 2 m/s. The first is
// at a height of 5 m.
struct Two {
  Scene scene;
  Batch<double> batch{Layout::soa, 2};
  Two() {
    scene.mass = std::vector<double>{2, 4};
    scene.origin = Vec3{100, 7, 0};
    scene.add(Constant{.acceleration = {0, -10, 0}});
    scene.add(Network(Springs{.pairs = {{1, 0}}, .stiffness = 6.0, .rest_length = Scalars(1.0), .zero_length = 2.0}));
    scene.add(Constraint(Distance{.pairs = {{1, 0}}, .length = Scalars(2.0)}));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < 2; ++i) batch.view().x[axis][i] = batch.view().v[axis][i] = 0;
    }
    batch.view().x[1][0] = batch.view().x[1][1] = -2;
    batch.view().x[0][1] = 3;
    batch.view().v[0][0] = 1;
    batch.view().v[2][1] = 2;
  }
};

TEST_CASE("check: closed forms of a spring, a rod, a weight and a speed, counted from an origin") {
  Two two;
  const Plan<double> plan = compile<double>(two.scene, {}, two.batch.view()).value();
  const StateCheck found = plan.check(two.batch.view());
  CHECK(found.stretch == doctest::Approx(3));
  CHECK(found.spring == Pair{0, 1});
  CHECK(found.off == doctest::Approx(0.5));
  CHECK(found.rod == Pair{0, 1});
  CHECK(found.elastic == doctest::Approx(0.5 * (6.0 * 2 * 2 + 2.0 * 9)));
  CHECK(found.kinetic == doctest::Approx(0.5 * (2 * 1 + 4 * 4)));
  CHECK(found.weight == doctest::Approx(6 * 10 * 5));
}

TEST_CASE("check: lengths left open are those of the start, and one-sided bounds are off on one side alone") {
  Two two;
  std::get<Springs>(two.scene.networks[0]).rest_length.reset();
  two.scene.constraints = {Distance{.pairs = {{0, 1}}, .bound = Bound::at_least},
                           Distance{.pairs = {{0, 1}}, .bound = Bound::at_most}};
  const Plan<double> plan = compile<double>(two.scene, {}, two.batch.view()).value();
  CHECK(plan.check(two.batch.view()).stretch == doctest::Approx(1));
  CHECK(plan.check(two.batch.view()).off == 0);
  two.batch.view().x[0][1] = 1.5;
  CHECK(plan.check(two.batch.view()).off == doctest::Approx(0.5));
  CHECK(plan.check(two.batch.view()).constraint == 0);
  two.batch.view().x[0][1] = 6;
  CHECK(plan.check(two.batch.view()).off == doctest::Approx(1));
  CHECK(plan.check(two.batch.view()).constraint == 1);
}

TEST_CASE("check: particles that are not finite are counted, the first is named, and lengths pass over them") {
  const Joined joined = test::sheet(9, 12, 200);
  Batch<float> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const Plan<float> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
  const double before = plan.check(batch.view()).stretch;
  batch.view().x[2][37] = std::numeric_limits<float>::quiet_NaN();
  batch.view().v[1][107] = std::numeric_limits<float>::infinity();
  batch.view().x[0][20] = -std::numeric_limits<float>::infinity();
  const StateCheck found = plan.check(batch.view());
  CHECK(found.not_finite == 3);
  CHECK(found.first_not_finite == 20);
  CHECK(found.stretch >= before);
  CHECK_FALSE(std::isfinite(found.elastic));
  CHECK_FALSE(std::isfinite(found.kinetic));
}

TEST_CASE("check: free particles have energy alone, and a wrong count or short columns are reported") {
  Scene scene;
  scene.mass = 2;
  scene.fixed = {1};
  Batch<double> batch(Layout::aos, 3);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < 3; ++i) {
      batch.view().x[axis][i] = 1;
      batch.view().v[axis][i] = 3;
    }
  }
  const Plan<double> free = compile<double>(scene, {}, batch.view()).value();
  CHECK(free.check(batch.view()).kinetic == doctest::Approx(2 * 0.5 * 2 * 27));
  CHECK(free.check(batch.view()).stretch == 0);

  const Joined joined = test::sheet(3, 3, 100);
  const Plan<double> sheet = test::plan_of<double>(joined, {.isa = best_isa()});
  CHECK(sheet.check(batch.view()).result == StepResult::count_differs);
  Batch<double> right(Layout::soa, 9);
  test::place(joined, right.view());
  right.view().v[1].capacity = 8;
  CHECK(sheet.check(right.view()).result == StepResult::capacity_too_small);
}

TEST_CASE("check: compensated states are looked at with their residuals") {
  const Joined joined = test::sheet(9, 12, 200);
  Batch<float> batch(Layout::soa, joined.x.size()), rests(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  for (auto* of : {&rests.view().x, &rests.view().v}) {
    for (const Column<float>& column : *of) {
      for (std::size_t i = 0; i < joined.x.size(); ++i) column[i] = 0;
    }
  }
  State<float> state = compensated(batch.view(), rests.view());
  Plan<float> plan = compile<float>(joined.scene, {.rounding = Rounding::compensated}, state).value();
  const StateCheck near = plan.check(state);
  REQUIRE(plan.teleport(state, {.translation = {1e6, 0, 0}}).has_value());
  const StateCheck far = plan.check(state);
  CHECK(far.stretch == doctest::Approx(near.stretch).epsilon(1e-6));
  CHECK(far.spring == near.spring);
  CHECK(far.elastic == doctest::Approx(near.elastic).epsilon(1e-5));
}

}  // namespace state_check_test
