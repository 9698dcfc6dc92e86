// Air on triangles: closed forms of a flat plate, quantities that must never grow, the order, and the bits of the scalar twins.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"

namespace air_test {

using namespace dvdx;
using test::Batch;
using test::is_close;
using test::Joined;
using test::Layout;
using test::Run;
using test::stepped;

constexpr double rho = 1.2;

Grid& grid_of(Joined& joined) { return std::get<Grid>(joined.scene.networks[0]); }
Joined with(Joined joined, const Coupling& coupling) {
  joined.scene.coupling = coupling;
  return joined;
}
Joined in_air(Joined joined, const Aerodynamics& air, Wind wind) {
  grid_of(joined).aerodynamics = air;
  joined.scene.wind = std::move(wind);
  return joined;
}

// A flat square metre at rest in the plane y = 0, without springs. The masses are the particles' shares of the triangles.
Joined plate(std::size_t rows, std::size_t columns, const Aerodynamics& air, const Vec3& wind, double mass) {
  Joined joined = in_air(test::sheet(rows, columns, 0), air, {.mean = wind});
  joined.scene.forces.clear();
  joined.scene.fixed.clear();
  std::vector<double> each(rows * columns, 0.0);
  const auto weigh = [&](std::size_t i) { each[i] += mass / static_cast<double>(6 * (rows - 1) * (columns - 1)); };
  for (std::size_t r = 0; r + 1 < rows; ++r) {
    for (std::size_t c = 0; c + 1 < columns; ++c) {
      const std::size_t i = r * columns + c;
      for (const std::size_t corner : {i, i + columns + 1, i + 1, i, i + columns + 1, i + columns}) weigh(corner);
    }
  }
  joined.scene.mass = Scalars(each);
  for (std::size_t i = 0; i < rows * columns; ++i) {
    joined.x[i] = {static_cast<double>(i % columns) / static_cast<double>(columns - 1), 0,
                   static_cast<double>(i / columns) / static_cast<double>(rows - 1)};
    joined.v[i] = {};
  }
  return joined;
}

Vec3 momentum(const Joined& joined, const std::vector<double>& values) {
  Vec3 sum{};
  for (std::size_t i = 0; i < joined.x.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += joined.scene.mass[i] * values[6 * i + 3 + axis];
  }
  return sum;
}

// J, relative to the wind.
double energy_in_wind(const Joined& joined, const std::vector<double>& values, const Vec3& wind) {
  double sum = 0;
  for (std::size_t i = 0; i < joined.x.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double u = values[6 * i + 3 + axis] - wind[axis];
      sum += 0.5 * joined.scene.mass[i] * u * u;
    }
  }
  return sum;
}

// Every way in which air acts: in the middle of a pulse, at two pulses of six, in halves around sweeps and contributions.
std::vector<Coupling> couplings() {
  return {{.scheme = Scheme::leapfrog},
          {.scheme = Scheme::fourth_order},
          {.scheme = Scheme::sequential},
          {.scheme = Scheme::sequential, .theta = 0.55},
          {.scheme = Scheme::sequential, .sweeps = SweepOrder::forward},
          {.scheme = Scheme::accumulate},
          {.scheme = Scheme::accumulate, .method = Method::combined}};
}

std::vector<Joined> grid_and_list(const Joined& joined) { return {joined, test::as_list(joined)}; }

TEST_CASE("air: the force on a flat plate at 0, 45 and 90 degrees") {
  constexpr double U = 8;
  constexpr double h = 1e-7;
  const Aerodynamics air{.density = rho, .drag = 1.1, .lift = 0.7};
  const double q = rho * U / 2;  // kg/s, for a square metre
  struct Case {
    Vec3 wind, force;
  };
  const double c = std::sqrt(0.5);
  const double along = air.drag * q * U * c - air.lift * q * c * c * U;  // along the wind's unit vector
  const std::array<Case, 4> cases{{{{0, U, 0}, {0, air.drag * q * U, 0}},
                                   {{0, -U, 0}, {0, -air.drag * q * U, 0}},
                                   {{U, 0, 0}, {0, 0, 0}},
                                   {{U * c, U * c, 0}, {along * c, along * c + air.lift * q * c * U, 0}}}};
  for (const auto& [wind, force] : cases) {
    for (Joined of : grid_and_list(plate(4, 6, air, wind, 0.5))) {
      of.step = h;
      for (const Coupling& coupling : couplings()) {
        const Vec3 p = momentum(of, stepped<double>(with(of, coupling), {}, 1));
        for (std::size_t axis = 0; axis < 3; ++axis) {
          CAPTURE(of.name);
          CAPTURE(axis);
          CHECK(std::abs(p[axis] / h - force[axis]) < 2e-5 * q * U);
        }
      }
    }
  }
}

TEST_CASE("air: face on, the speed falls by the quadratic law, exactly and at any step") {
  constexpr double U = 12;
  constexpr double mass = 0.1;
  const Aerodynamics air{.density = rho, .drag = 1.3, .lift = 0.4};
  for (const double h : {0.001, 0.1, 10.0}) {
    for (Joined of : grid_and_list(plate(5, 19, air, {0, U, 0}, mass))) {
      of.step = h;
      const std::vector<double> values = stepped<double>(with(of, {.substeps = 1}), {}, 1);
      const double left = U / (1 + rho * air.drag * U * h / (2 * mass));
      for (std::size_t i = 0; i < of.x.size(); ++i) CHECK(is_close(U - values[6 * i + 4], left, 1e-11 * (1 + U * h / mass)));
    }
  }
}

TEST_CASE("air: a sheet that falls face on reaches its terminal speed") {
  constexpr double mass = 0.2;
  const Aerodynamics air{.density = rho, .drag = 1.05, .lift = 0.5};
  Joined of = plate(6, 6, air, {}, mass);
  of.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  of.step = 1.0 / 240;
  const double speed = std::sqrt(2 * mass * 9.81 / (rho * air.drag));
  // If a step ends with half or all of its air, half or all of gravity's next part is still to come.
  const double apart = 1e-3 * speed + 0.51 * 9.81 * of.step;
  for (const Coupling& coupling : couplings()) {
    const std::vector<double> values = stepped<double>(with(of, coupling), {}, 480);
    for (std::size_t i = 0; i < of.x.size(); ++i) CHECK(std::abs(-values[6 * i + 4] - speed) < apart);
  }
}

TEST_CASE("air: cloth that moves with the wind feels nothing, and only the speed between them counts") {
  constexpr Vec3 boost{3, -2, 5};
  constexpr std::size_t steps = 20;
  Joined still = in_air(test::sheet(7, 9, 40, 0.002), {.density = rho}, {.mean = {1, 2, -4}});
  still.scene.fixed.clear();
  for (const Joined& of : grid_and_list(still)) {
    for (const Coupling& coupling : couplings()) {
      const Joined at_rest = with(of, coupling);
      Joined moving = at_rest;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        moving.scene.wind.mean[axis] += boost[axis];
        for (Vec3& v : moving.v) v[axis] += boost[axis];
      }
      const auto wanted = stepped<double>(at_rest, {}, steps);
      const auto got = stepped<double>(moving, {}, steps);
      double apart = 0;
      for (std::size_t k = 0; k < wanted.size(); ++k) {
        const std::size_t axis = k % 6;
        const double way = axis < 3 ? boost[axis] * steps * of.step : boost[axis - 3];
        apart = std::max(apart, std::abs(got[k] - way - wanted[k]));
      }
      CHECK_MESSAGE(apart < 1e-9, of.name << ", scheme " << static_cast<int>(coupling.scheme) << ": " << apart);
    }
  }
  Joined carried = plate(5, 7, {.density = 1e3}, boost, 0.1);
  for (Vec3& v : carried.v) v = boost;
  for (const double value : {stepped<double>(carried, {}, 30)[3], stepped<double>(carried, {}, 30)[6 * 17 + 3]}) {
    CHECK(is_close(value, boost[0], 1e-14));
  }
}

TEST_CASE("air: it never gives cloth energy and never turns it round, however dense it is or coarse the step") {
  constexpr Vec3 wind{4, -7, 3};
  for (const Aerodynamics& air : {Aerodynamics{1e6, 1, 0.5}, Aerodynamics{1e6, 0, 1}, Aerodynamics{1.2, 1, 3},
                                  Aerodynamics{50, 0.01, 2}, Aerodynamics{1e9, 2, 0}}) {
    Joined crumpled = in_air(test::sheet(9, 20, 0), air, {.mean = wind});
    crumpled.scene.forces.clear();
    crumpled.scene.fixed.clear();
    crumpled.step = 1.0 / 30;
    for (std::size_t i = 0; i < crumpled.x.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        crumpled.x[i][axis] += 0.1 * test::scatter(i, 7 + axis);
        crumpled.v[i][axis] = 10 * test::scatter(i, 17 + axis);
      }
    }
    for (const Joined& form : grid_and_list(crumpled)) {
      for (const Coupling& coupling : couplings()) {
        const Joined of = with(form, coupling);
        Batch<double> batch(Layout::soa, of.x.size());
        test::place(of, batch.view());
        const auto plan = test::plan_of(of, {}, batch.view());
        double before = energy_in_wind(of, test::values_of(batch.view()), wind);
        for (int n = 0; n < 12; ++n) {
          REQUIRE(plan.step(batch.view()) == StepResult::done);
          const double now = energy_in_wind(of, test::values_of(batch.view()), wind);
          REQUIRE(now <= before * (1 + 1e-12));
          before = now;
        }
      }
    }
  }
  // One plate, whose pulse only turns and shortens u.
  for (const double lift : {0.0, 0.5, 3.0}) {
    for (const double h : {0.01, 1.0, 1e4}) {
      for (double angle = 0.05; angle < 1.57; angle += 0.1) {
        Joined of =
            plate(2, 2, {.density = 100, .drag = 0.2, .lift = lift}, {9 * std::sin(angle), 9 * std::cos(angle), 0}, 0.1);
        of.step = h;
        const std::vector<double> values = stepped<double>(with(of, {.substeps = 1}), {}, 1);
        const Vec3 p = momentum(of, values);
        const double across = of.scene.wind.mean[1] - p[1] / 0.1;  // the remaining u along the normal
        CHECK(across >= 0);
        CHECK(std::hypot(of.scene.wind.mean[0] - p[0] / 0.1, across) <= 9 * (1 + 1e-12));
      }
    }
  }
}

TEST_CASE("air: it is of second order by every scheme, with springs, gusts and lift" * doctest::test_suite("long")) {
  Joined flag = in_air(test::sheet(8, 10, 30), {.density = 3, .drag = 1, .lift = 0.8},
                       {.mean = {4, 1, 2}, .gusts = {{.amplitude = {0, 0, 3}, .angular_frequency = 9, .phase = 0.3}}});
  flag.step = 0.04;
  const auto end_of = [](const Joined& form, Scheme scheme, int substeps) {
    return stepped<double>(with(form, {.scheme = scheme, .substeps = substeps}), {.isa = best_isa()}, 10);
  };
  for (const double damping : {0.0, 0.002}) {
    grid_of(flag).damping = damping;
    const std::vector<double> finest = end_of(flag, Scheme::leapfrog, 8192);  // also the list's, except for rounding
    for (const Joined& form : grid_and_list(flag)) {
      for (const auto& [scheme, least] :
           {std::pair{Scheme::leapfrog, 128}, {Scheme::fourth_order, 64}, {Scheme::sequential, 256}}) {
        double coarse = 0;
        for (const int substeps : {least, 2 * least, 4 * least}) {
          const std::vector<double> values = end_of(form, scheme, substeps);
          double error = 0;
          for (std::size_t k = 0; k < values.size(); ++k) error = std::max(error, std::abs(values[k] - finest[k]));
          const int number = static_cast<int>(scheme);  // clang++ 14 cannot capture a structured binding
          if (coarse != 0)
            CHECK_MESSAGE(std::log2(coarse / error) > 1.8, form.name << ", scheme " << number << ", damping " << damping << ", "
                                                                     << substeps << " sub-steps: " << error << ", order "
                                                                     << std::log2(coarse / error));
          coarse = error;
        }
      }
    }
  }
}

TEST_CASE("air: the bits depend neither on the instruction set, nor on threads, nor on layout") {
  const Wind wind{.mean = {3, 1, -2}, .gusts = {{{0, 0, 2}, 7, 0.5}, {{1, 0, 0}, 3, 0}}};
  std::vector<Joined> scenes;
  for (const auto& [rows, columns] : {std::pair{2U, 2U}, {3U, 5U}, {7U, 33U}}) {
    scenes.push_back(in_air(test::sheet(rows, columns, 30), {}, wind));
  }
  scenes.push_back(in_air(test::sheet(9, 20, 30, 0.001), {.density = 900, .drag = 0.3, .lift = 2}, wind));
  grid_of(scenes.back()).broken = {{0, 1}, {20, 40}, {61, 82}, {85, 104}};
  Joined bad = in_air(test::sheet(5, 18, 30), {}, wind);
  bad.x[40][1] = std::numeric_limits<double>::quiet_NaN();
  bad.v[12][0] = std::numeric_limits<double>::infinity();
  scenes.push_back(bad);
  const auto check = [&]<class T>(T, const Joined& of, Arithmetic arithmetic) {
    const std::vector<T> wanted = stepped<T>(of, {.arithmetic = arithmetic}, 2);
    for (const Isa isa : available_isas(arithmetic)) {
      const Run run{.isa = isa, .arithmetic = arithmetic, .layout = Layout::aos, .threads = 2};
      CHECK_MESSAGE(test::difference(wanted, stepped<T>(of, run, 2)) == "", of.name << ' ' << name(isa));
    }
  };
  const Joined wide = in_air(test::sheet(2, 600, 30), {}, wind);  // wider than a stripe
  check(float{}, with(wide, {.substeps = 20}), Arithmetic::separate);
  check(double{}, with(wide, {.substeps = 20}), Arithmetic::contracted);
  std::size_t turn = 0;  // precisions and arithmetics take turns
  for (const Joined& scene : scenes) {
    for (const Joined& form : grid_and_list(scene)) {
      for (Coupling coupling : couplings()) {
        if (coupling.scheme == Scheme::sequential) coupling.substeps = 2;  // any number is allowed, so none is searched
        const bool is_odd = turn++ % 2 != 0;
        check(float{}, with(form, coupling), is_odd ? Arithmetic::contracted : Arithmetic::separate);
        check(double{}, with(form, coupling), is_odd ? Arithmetic::separate : Arithmetic::contracted);
      }
    }
  }
}

TEST_CASE("air: a grid's triangles are those of its list") {
  Joined of = in_air(test::sheet(9, 20, 30), {.density = 5, .drag = 0.8, .lift = 1.5}, {.mean = {3, 1, -2}});
  grid_of(of).broken = {{0, 1}, {20, 40}, {61, 82}, {85, 104}};
  const std::vector<double> grid = stepped<double>(of, {}, 20);
  const std::vector<double> list = stepped<double>(test::as_list(of), {}, 20);
  double apart = 0;
  for (std::size_t k = 0; k < grid.size(); ++k) apart = std::max(apart, std::abs(grid[k] - list[k]));
  CHECK(apart < 1e-10);
}

TEST_CASE("air: kinematic particles are not moved by it, and their velocity counts") {
  const Aerodynamics air{.density = 30};
  Joined carried = plate(2, 2, air, {}, 0.1);
  carried.scene.add(Motion{.keys = {{.time = 0}, {.time = 1, .translation = {0, -6, 0}}}});
  carried.scene.add(Kinematic{.particles = {0, 1, 2}, .motion = 0});
  carried.step = 1e-6;
  for (const Joined& form : grid_and_list(carried)) {
    for (const Coupling& coupling : couplings()) {
      const std::vector<double> values = stepped<double>(with(form, coupling), {}, 1);
      CHECK(is_close(values[4], -6, 1e-12));
      // Each triangle has two of its three corners at 6 m/s in still air. The fourth particle is a corner of both triangles.
      const double u = 4;
      const double force = 2 * air.density * 0.5 * u * u / 2 / 3;
      CHECK(is_close(values[6 * 3 + 4] * carried.scene.mass[3] / carried.step, force, 1e-3));
    }
  }
}

TEST_CASE("air: a triangle with a torn side meets no air") {
  Joined of = plate(3, 3, {.density = 10}, {0, 5, 0}, 0.1);
  grid_of(of).structural = 1;
  grid_of(of).broken = {{0, 1}, {0, 3}, {0, 4}};
  for (const Joined& form : grid_and_list(of)) {
    const std::vector<double> values = stepped<double>(form, {}, 1);
    CHECK(values[4] == 0);  // the corner particle: both of its triangles have torn sides
    CHECK(values[6 * 8 + 4] > 0);
  }
}

TEST_CASE("air: wrong values are refused by their field, value and range") {
  const auto refusal = [](const Joined& joined) {
    Batch<double> batch(Layout::soa, joined.x.size());
    test::place(joined, batch.view());
    const auto plan = compile<double>(joined.scene, {.step = joined.step}, batch.view());
    REQUIRE(!plan.has_value());
    return plan.error().message();
  };
  const Joined good = in_air(test::sheet(3, 3, 30), {}, {});
  CHECK(refusal(in_air(good, {.density = -1}, {})) == "networks[0].aerodynamics.density is -1: must be a finite number >= 0");
  CHECK(refusal(in_air(good, {.drag = -1}, {})) == "networks[0].aerodynamics.drag is -1: must be a number from 0 to 1e+06");
  CHECK(refusal(in_air(good, {.lift = 2e6}, {})) == "networks[0].aerodynamics.lift is 2e+06: must be a number from 0 to 1e+06");
  constexpr double infinite = std::numeric_limits<double>::infinity();
  CHECK(refusal(in_air(good, {}, {.mean = {0, infinite, 0}})) == "wind.mean[1] is inf: must be a finite number");
  CHECK(refusal(in_air(good, {}, {.gusts = {{.angular_frequency = infinite}}})) ==
        "wind.gusts[0].angular_frequency is inf: must be a finite number");
  Joined list = test::as_list(good);
  auto& springs = std::get<Springs>(list.scene.networks[0]);
  springs.triangles[1] = {0, 4, 4};
  CHECK(refusal(list) == "networks[0].triangles[1] is [0], [4] and [4]: must be three different particle ids below 9");
  springs.triangles.clear();
  CHECK(refusal(list) == "networks[0].aerodynamics is given: must be left out of a network without triangles");
}

TEST_CASE("air: the wind may change while a plan runs, and a refused change changes nothing") {
  const Joined before = in_air(test::sheet(6, 9, 30), {}, {.mean = {3, 0, 0}, .gusts = {{{0, 1, 0}, 5, 0}}});
  Joined after = before;
  after.scene.wind = {.mean = {0, 2, 7}, .gusts = {{{0, 0, 2}, 3, 1}}};
  for (const bool is_list : {false, true}) {
    const Joined from = is_list ? test::as_list(before) : before;
    const Joined to = is_list ? test::as_list(after) : after;
    Batch<double> batch(Layout::soa, from.x.size());
    test::place(from, batch.view());
    auto plan = test::plan_of(from, {}, batch.view());
    Plan<double> clone = plan.clone();
    REQUIRE(plan.set_wind(after.scene.wind).has_value());
    CHECK(plan.scene() == to.scene);
    CHECK(!plan.set_wind({.mean = {0, std::nan(""), 0}}).has_value());
    const auto too_fast = plan.set_wind({.mean = {1e99, 0, 0}});
    REQUIRE(!too_fast.has_value());
    CHECK(too_fast.error().field == "wind");
    CHECK(plan.scene() == to.scene);
    REQUIRE(plan.step(batch.view(), 4) == StepResult::done);
    CHECK(test::difference(stepped<double>(to, {.isa = best_isa()}, 4), test::values_of(batch.view())) == "");
    test::place(from, batch.view());
    batch.view().clock = {};
    REQUIRE(clone.step(batch.view(), 4) == StepResult::done);
    CHECK(test::difference(stepped<double>(from, {.isa = best_isa()}, 4), test::values_of(batch.view())) == "");
    REQUIRE(clone.set_wind(after.scene.wind).has_value());  // shared or not, the result is the same
    test::place(from, batch.view());
    batch.view().clock = {};
    REQUIRE(clone.step(batch.view(), 4) == StepResult::done);
    CHECK(test::difference(stepped<double>(to, {.isa = best_isa()}, 4), test::values_of(batch.view())) == "");
  }
}

}  // namespace air_test
