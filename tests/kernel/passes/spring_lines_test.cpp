// Lines of springs that sequential solves at once: sag at rest, both momenta, no heat, and the scalar reference's bits.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"

namespace spring_lines_test {

using namespace dvdx;
using test::in_order;
using test::Joined;
using test::Run;
using test::shuffled;
using test::stepped;

constexpr double gravity = 9.81;
constexpr Coupling one_substep{.scheme = Scheme::sequential, .substeps = 1, .lines = Lines::whole};
constexpr Coupling without_lines{.scheme = Scheme::sequential, .substeps = 1, .lines = Lines::none};

// ---- ropes ------------------------------------------------------------------------------------------------------------------

struct Rope {
  std::size_t springs = 20;
  double k = 1e6;                  // N/m
  double link = 0.01, load = 100;  // kg
  double apart = 0.1;              // m
  Vec3 way{0, -1, 0};              // direction of the rope at the start
};

// A rope that hangs by its first particle, with its springs at their equilibrium lengths.
Joined hanging(const Rope& rope) {
  Joined joined;
  Springs springs{.pairs = {}, .stiffness = rope.k, .rest_length = Scalars(rope.apart)};
  std::vector<double> masses(rope.springs + 1, rope.link);
  masses.back() = rope.load;
  double y = 0;
  for (std::uint32_t i = 0; i <= rope.springs; ++i) {
    joined.x.push_back({0, y, 0});
    joined.v.push_back({0, 0, 0});
    if (i == rope.springs) break;
    springs.pairs.push_back({i, i + 1});
    const double below = rope.load + rope.link * static_cast<double>(rope.springs - 1 - i);
    y -= rope.apart + below * gravity / rope.k;
  }
  joined.name = "a rope of " + std::to_string(rope.springs) + " springs";
  joined.scene.mass = Scalars(masses);
  joined.scene.add(Constant{.acceleration = {0, -gravity, 0}});
  joined.scene.add(Network(springs));
  joined.scene.fixed = {0};
  return joined;
}

double stretch(const Rope& rope, double y_of_load) { return -y_of_load - rope.apart * static_cast<double>(rope.springs); }

TEST_CASE("spring lines: a rope holds its load by one sub-step, however stiff it is and whatever hangs on it") {
  for (const Rope& rope : {Rope{}, Rope{.springs = 40, .k = 2e6, .load = 200}, Rope{.springs = 3, .k = 1e8, .load = 1e4},
                           Rope{.springs = 200, .k = 1e7, .link = 0.1, .load = 50}, Rope{.springs = 17, .k = 3e4, .load = 0.01},
                           Rope{.springs = 20, .k = 1e9, .link = 1e-4, .load = 1e4}}) {
    Joined joined = hanging(rope);
    const double wanted = stretch(rope, joined.x.back()[1]);
    for (const double step : {1.0 / 24, 1.0 / 60}) {
      joined.step = step;
      joined.scene.coupling = one_substep;
      const std::size_t at = 6 * rope.springs + 1;
      const double found = stretch(rope, stepped<double>(joined, {.isa = best_isa()}, 90)[at]);
      CAPTURE(joined.name);
      CAPTURE(step);
      // A sub-step ends half of its length after the springs' pulse.
      const double bound = 0.02 * wanted + 1.05 * gravity * step * step / 8;
      CHECK(std::abs(found - wanted) < bound);
      // A rounding error of the forces moves the lightest links in proportion to their inverse mass.
      const double in_float = stretch(rope, static_cast<double>(stepped<float>(joined, {.isa = best_isa()}, 90)[at]));
      const double rounding = 1e-6 * static_cast<double>(rope.springs) * (1 + rope.load / rope.link * gravity * step * step);
      CHECK(std::abs(in_float - wanted) < bound + rounding);
      joined.scene.coupling = without_lines;
      if (rope.springs > 3 && rope.load > 1)
        CHECK(stretch(rope, stepped<double>(joined, {.isa = best_isa()}, 90)[at]) > 2 * wanted);
    }
  }
}

// Displaces particles by 1e-5 m. Tension turns light links by more than their length within a sub-step.
void scatter_across(Joined& joined) {
  for (std::size_t i = 1; i < joined.x.size(); ++i) {
    joined.x[i][0] += 1e-5 * test::scatter(i, 0);
    joined.x[i][2] += 1e-5 * test::scatter(i, 2);
  }
}

TEST_CASE("spring lines: a rope that does not hang quite straight holds its load, and comes to rest") {
  for (const Rope& rope : {Rope{}, Rope{.springs = 40, .k = 2e6, .load = 200}, Rope{.springs = 20, .k = 1e4, .load = 1}}) {
    Joined joined = hanging(rope);
    const double wanted = -joined.x.back()[1];
    scatter_across(joined);
    joined.step = 1.0 / 60;
    joined.scene.add(Drag{.coefficient = 0.1 * rope.link});
    joined.scene.coupling = one_substep;
    CAPTURE(joined.name);
    const std::vector<double> values = stepped<double>(joined, {.isa = best_isa()}, 600);
    const double found = -values[6 * rope.springs + 1];
    CHECK(std::abs(found - wanted) < 0.002 * wanted);
    for (std::size_t i = 0; i < values.size(); i += 6) {
      CHECK(std::abs(values[i]) < 1e-4);
      CHECK(std::abs(values[i + 5]) < 1e-3);
    }
  }
}

// ---- sheets -----------------------------------------------------------------------------------------------------------------

struct Sheet {
  std::size_t side = 16;
  double k = 1e4;  // N/m
  bool by_row = false;
  double drag = 3;  // 1/s
};

// A sheet of 1 m and 1 kg, hung in its plane by two corners or by its first row.
Joined hung(const Sheet& sheet) {
  Joined joined;
  const std::size_t n = sheet.side;
  const double apart = 1 / static_cast<double>(n - 1);
  for (std::size_t i = 0; i < n * n; ++i) {
    joined.x.push_back({apart * static_cast<double>(i % n), -apart * static_cast<double>(i / n), 0});
    joined.v.push_back({0, 0, 0});
  }
  const double mass = 1 / static_cast<double>(n * n);
  joined.name = std::to_string(n) + " a side by " + (sheet.by_row ? "a row" : "corners");
  joined.scene.mass = mass;
  joined.scene.add(Constant{.acceleration = {0, -gravity, 0}});
  joined.scene.add(Drag{.coefficient = mass * sheet.drag});
  joined.scene.add(Network(
      Grid{.rows = n, .columns = n, .edge_u = {1, 0, 0}, .edge_v = {0, -1, 0}, .structural = sheet.k, .shear = sheet.k}));
  if (sheet.by_row) {
    for (std::size_t i = 0; i < n; ++i) joined.scene.fixed.push_back(i);
  } else {
    joined.scene.fixed = {0, n - 1};
  }
  return joined;
}

double lowest(const std::vector<double>& values) {
  double y = 0;
  for (std::size_t i = 1; i < values.size(); i += 6) y = std::min(y, values[i]);
  return y;
}

// Not numbered in rows, and with a spring that no sheet has.
Joined as_colours(const Joined& joined) { return test::with_spring_across(test::as_list(joined)); }

TEST_CASE("spring lines: a sheet hangs as deep by one sub-step of 1/60 s as leapfrog has it") {
  for (const Sheet& sheet :
       {Sheet{}, Sheet{.by_row = true}, Sheet{.side = 20, .k = 300}, Sheet{.side = 18, .k = 1e5, .by_row = true}}) {
    Joined joined = hung(sheet);
    joined.step = 1.0 / 60;
    joined.scene.coupling = {.scheme = Scheme::leapfrog};
    const double wanted = lowest(stepped<double>(joined, {.isa = best_isa()}, 150));
    joined.scene.coupling = one_substep;
    CAPTURE(joined.name);
    const double found = lowest(stepped<double>(joined, {.isa = best_isa()}, 150));
    MESSAGE(joined.name << ": " << found << " for " << wanted);
    CHECK(test::is_close(found, wanted, 0.02));
    joined.scene.coupling = without_lines;
    CHECK(lowest(stepped<double>(joined, {.isa = best_isa()}, 150)) < 1.03 * wanted);
  }
}

TEST_CASE("spring lines: a sheet that does not hang quite in its plane hangs as deep") {
  for (const Sheet& sheet : {Sheet{}, Sheet{.side = 48, .by_row = true}}) {
    Joined joined = hung(sheet);
    for (std::size_t i = sheet.side; i < joined.x.size(); ++i) joined.x[i][2] += 1e-5 * test::scatter(i, 2);
    joined.step = 1.0 / 60;
    joined.scene.coupling = one_substep;
    CAPTURE(joined.name);
    // By leapfrog 1.0009 and 1.0003 m, in the plane.
    const double wanted = sheet.by_row ? -1.0003 : -1.0009;
    CHECK(test::is_close(lowest(stepped<double>(joined, {.isa = best_isa()}, 150)), wanted, sheet.by_row ? 0.005 : 0.01));
  }
}

// A free sheet that turns and is bent.
Joined free_sheet(std::size_t rows, std::size_t columns, double damping) {
  Joined joined = test::sheet(rows, columns, 500, damping);
  joined.scene.forces.clear();
  joined.scene.fixed.clear();
  for (std::size_t i = 0; i < joined.x.size(); ++i) {
    joined.v[i][0] += 3 * joined.x[i][2];
    joined.v[i][2] -= 3 * joined.x[i][0];
    joined.v[i][1] += joined.x[i][0] * joined.x[i][2];
  }
  joined.name += " in flight";
  return joined;
}

// Momenta divided by a particle's mass.
std::array<double, 6> momenta(const std::vector<double>& values) {
  std::array<double, 6> sums{};
  for (std::size_t i = 0; i < values.size(); i += 6) {
    const double* const x = &values[i];
    const double* const v = x + 3;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t next = (axis + 1) % 3, last = (axis + 2) % 3;
      sums[axis] += v[axis];
      sums[3 + axis] += x[next] * v[last] - x[last] * v[next];
    }
  }
  return sums;
}

std::vector<double> values_at_start(const Joined& joined) {
  std::vector<double> values;
  for (std::size_t i = 0; i < joined.x.size(); ++i) {
    values.insert(values.end(), joined.x[i].begin(), joined.x[i].end());
    values.insert(values.end(), joined.v[i].begin(), joined.v[i].end());
  }
  return values;
}

TEST_CASE("spring lines: a sheet in flight keeps its momentum to rounding, and nearly all of its angular momentum") {
  for (const bool is_list : {false, true}) {
    Joined joined = free_sheet(20, 23, 1e-3);
    if (is_list) joined = as_colours(joined);
    CAPTURE(joined.name);
    const std::array<double, 6> wanted = momenta(values_at_start(joined));
    joined.scene.coupling = {.scheme = Scheme::sequential, .substeps = 4, .lines = Lines::whole};
    const std::array<double, 6> found = momenta(stepped<double>(joined, {.isa = best_isa()}, 20));
    for (std::size_t axis = 0; axis < 3; ++axis) CHECK(std::abs(found[axis] - wanted[axis]) < 1e-11 * 460);
    for (std::size_t axis = 3; axis < 6; ++axis) {
      CHECK(std::abs(found[axis] - wanted[axis]) < 0.005 * std::abs(wanted[4]));
    }
  }
}

TEST_CASE("spring lines: a sheet that falls and crumples has no more energy than gravity gives") {
  for (const double k : {300.0, 1e4, 1e6}) {
    for (const bool is_list : {false, true}) {
      Joined joined = hung({.side = 20, .k = k, .drag = 0});
      for (std::size_t i = 0; i < joined.x.size(); ++i) {
        joined.x[i] = {joined.x[i][0], 0, -joined.x[i][1]};
        joined.v[i] = {1e-6 * test::scatter(i, 0), 1e-6 * test::scatter(i, 1), 1e-6 * test::scatter(i, 2)};
      }
      auto& grid = std::get<Grid>(joined.scene.networks[0]);
      grid.edge_v = {0, 0, 1};
      if (is_list) joined = as_colours(joined);
      joined.scene.coupling = one_substep;
      test::Batch<double> batch(test::Layout::soa, joined.x.size());
      test::place(joined, batch.view());
      const Plan<double> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
      double deepest = 0, most = 0;
      for (int frame = 0; frame < 100; ++frame) {
        REQUIRE(plan.step(batch.view(), 1) == StepResult::done);
        const std::vector<double> values = test::values_of(batch.view());
        double kinetic = 0, potential = 0;
        for (std::size_t i = 0; i < values.size(); i += 6) {
          const double* const v = &values[i + 3];
          kinetic += 0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
          potential += gravity * values[i + 1];
        }
        deepest = std::min(deepest, potential);
        most = std::max(most, kinetic / std::max(-deepest, 0.1 * gravity * 400));
      }
      CAPTURE(joined.name);
      CAPTURE(k);
      CHECK(most < 1.3);
    }
  }
}

double energy(const Joined& joined, const std::vector<double>& values) {  // J, for equal masses
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); i += 6) {
    const double* const v = &values[i + 3];
    sum += joined.scene.mass[0] * (gravity * values[i + 1] + 0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
  }
  return sum;
}

// Held by a row and released flat with up to 2 m/s: waves run along the sheet that compress its springs strongly.
TEST_CASE("spring lines: forces of springs that are pressed hard are not redirected: they would give a sheet energy") {
  Joined joined = hung({.side = 27, .k = 8e3, .by_row = true, .drag = 0});
  joined.scene.forces.resize(1);
  std::get<Grid>(joined.scene.networks[0]).edge_v = {0, 0, -1};
  for (std::size_t i = 0; i < joined.x.size(); ++i) {
    const double x = joined.x[i][0], z = joined.x[i][1];
    joined.x[i] = {x, 0, z};
    joined.v[i] = {std::sin(3 * z), 2 * std::sin(2 * x + z), 2 * std::cos(2 * x)};
  }
  joined.step = 1.0 / 60;
  joined.scene.coupling = {.scheme = Scheme::sequential, .substeps = 1};
  test::Batch<double> batch(test::Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const Plan<double> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
  CHECK(plan.network_limit()->estimate.turning > 2);
  const double at_start = energy(joined, test::values_of(batch.view()));
  double most = at_start;
  for (int frame = 0; frame < 360; ++frame) {
    REQUIRE(plan.step(batch.view(), 1) == StepResult::done);
    most = std::max(most, energy(joined, test::values_of(batch.view())));
  }
  CHECK(most < at_start + 0.01 * gravity);
}

// ---- bits -------------------------------------------------------------------------------------------------------------------

template <class T>
void check_bits(Joined joined, Arithmetic arithmetic) {
  if (!joined.scene.coupling.substeps) {
    joined.scene.coupling = {.scheme = Scheme::sequential, .substeps = 2, .lines = Lines::whole};
  }
  const std::vector<T> wanted = stepped<T>(joined, {.arithmetic = arithmetic}, 2);
  for (const Isa isa : available_isas(arithmetic)) {
    // Below 16384 particles threads share no sweep, so one thread count is enough.
    const std::string difference =
        test::difference(wanted, stepped<T>(joined, {.isa = isa, .arithmetic = arithmetic, .threads = 2}, 2));
    CHECK_MESSAGE(difference.empty(),
                  joined.name << ", " << 8 * sizeof(T) << " bits, " << std::string(name(isa)) << ": " << difference);
  }
}

// Individual masses, some fixed particles, some torn springs, a bad particle, and two particles in one place.
Joined with_faults(Joined joined) {
  const std::size_t count = joined.x.size();
  joined.scene.mass.make_each(count);
  for (std::size_t i = 0; i < count; ++i) joined.scene.mass.set(i, 0.001 * std::pow(10, 3 * test::scatter(i, 6)));
  std::visit(
      [&](auto& network) {
        for (std::uint32_t i = 0; i < count; i += 13) {
          const auto end = static_cast<std::uint32_t>(i + 1);
          using Kind = std::decay_t<decltype(network)>;
          if constexpr (std::is_same_v<Kind, Grid>) {
            if (i % network.columns + 1 < network.columns) network.broken.push_back({i, end});
          } else {
            const auto& pairs = network.pairs;
            if (!pairs.empty()) network.broken.push_back(pairs[i % pairs.size()]);
          }
        }
      },
      joined.scene.networks[0]);
  if (count > 40) {
    joined.scene.fixed.push_back(count / 2);
    std::sort(joined.scene.fixed.begin(), joined.scene.fixed.end());
    joined.x[count / 3][1] = std::numeric_limits<double>::quiet_NaN();
    joined.x[count / 4] = joined.x[count / 4 + 1];
  }
  joined.name += ", with faults";
  return joined;
}

TEST_CASE("spring lines: sheets of every shape give the scalar reference's bits on every ISA, whatever the threads") {
  for (const auto& [rows, columns] : {std::pair{2U, 2U}, {2U, 40U}, {17U, 3U}, {5U, 16U}, {15U, 37U}, {36U, 33U}, {19U, 66U}}) {
    for (const double damping : {0.0, 1e-4}) {
      for (const double bend : {0.0, 5.0}) {
        Joined joined = test::sheet(rows, columns, 500, damping);
        if (rows < 3 || columns < 3) joined.scene.fixed = {0};
        std::get<Grid>(joined.scene.networks[0]).bend = bend;
        const bool is_odd = (damping == 0) == (bend == 0);  // takes turns, so that each meets both dampings and both bends
        if (is_odd) check_bits<float>(joined, Arithmetic::separate);
        if (!is_odd) check_bits<double>(joined, Arithmetic::contracted);
        if (rows > 4) check_bits<float>(with_faults(is_odd ? joined : test::as_list(joined)), Arithmetic::separate);
      }
    }
  }
}

// A towel let go: its springs are at rest but for rounding. The lines of 64 columns end where the next ones begin.
TEST_CASE("spring lines: a sheet whose rows fill their registers gives the scalar reference's bits on every ISA") {
  constexpr std::size_t rows = 3, columns = 64, steps = 4;
  Joined joined;
  joined.name = "towel";
  for (std::size_t i = 0; i < rows * columns; ++i) {
    const double u = static_cast<double>(i % columns) / (columns - 1), w = static_cast<double>(i / columns) / (rows - 1);
    joined.x.push_back({0.63 * u - 0.315, 0.68 - 0.63 * w, 0.03 * w});
  }
  joined.v.resize(joined.x.size());
  joined.scene.mass = 5e-5;
  joined.scene.add(Network(Grid{
      .rows = rows, .columns = columns, .edge_u = {0.63, 0, 0}, .edge_v = {0, -0.63, 0.03}, .structural = 400, .shear = 100}));
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  joined.scene.add(Drag{.coefficient = 3e-5});
  joined.scene.coupling = {.scheme = Scheme::sequential, .substeps = 1};
  const std::vector<float> wanted = stepped<float>(joined, {}, steps);
  for (const Isa isa : available_isas()) {
    const std::string difference = test::difference(wanted, stepped<float>(joined, {.isa = isa}, steps));
    CHECK_MESSAGE(difference.empty(), std::string(name(isa)) << ": " << difference);
  }
}

double turning_of(const Joined& joined) { return test::plan_of<double>(joined, {}).network_limit()->estimate.turning; }

// Adds weight until the estimate's turning is five, so that line forces are redirected.
Joined loaded(Joined joined) {
  joined.scene.coupling = {.scheme = Scheme::sequential, .substeps = 2};
  joined.scene.forces.clear();
  joined.scene.add(Constant{.acceleration = {0, -gravity, 0}});
  const double scale = 5 / turning_of(joined);
  joined.scene.forces.clear();
  joined.scene.add(Constant{.acceleration = {0, -gravity * scale * scale, 0}});
  joined.name += ", loaded";
  return joined;
}

TEST_CASE("spring lines: sheets whose lines' forces are redirected give the scalar reference's bits on every ISA") {
  for (const auto& [rows, columns] : {std::pair{2U, 40U}, {17U, 3U}, {15U, 37U}, {36U, 33U}, {19U, 66U}}) {
    for (const double damping : {0.0, 1e-4}) {
      Joined joined = test::sheet(rows, columns, 500, damping);
      std::get<Grid>(joined.scene.networks[0]).bend = damping * 1e4;
      if (rows < 3 || columns < 3) joined.scene.fixed = {0};
      const Joined sheet = loaded(joined);
      CHECK(turning_of(sheet) == doctest::Approx(5));
      CHECK(test::plan_of<float>(sheet, {}).explain().find("whose forces are redirected") != std::string::npos);
      if (damping == 0) check_bits<float>(sheet, Arithmetic::separate);
      if (damping != 0) check_bits<double>(sheet, Arithmetic::contracted);
      if (rows > 4) check_bits<float>(with_faults(damping == 0 ? sheet : test::as_list(sheet)), Arithmetic::separate);
    }
  }
}

TEST_CASE("spring lines: redirected forces keep the momentum of a sheet that nothing holds to rounding") {
  Joined joined = loaded(test::sheet(12, 15, 500));
  test::Batch<double> batch(test::Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  Plan<double> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
  REQUIRE(plan.set_force(0, Constant{.acceleration = {0, 0, 0}}).has_value());
  for (const std::size_t i : joined.scene.fixed) REQUIRE(plan.release(i).has_value());
  const std::array<double, 6> before = momenta(test::values_of(batch.view()));
  REQUIRE(plan.step(batch.view(), 20) == StepResult::done);
  const std::array<double, 6> after = momenta(test::values_of(batch.view()));
  for (std::size_t axis = 0; axis < 3; ++axis) CHECK(std::abs(after[axis] - before[axis]) < 1e-11 * 180);
}

TEST_CASE("spring lines: lists in any order give the scalar reference's bits on every ISA, whatever the threads") {
  for (const double damping : {0.0, 1e-4}) {
    for (const auto& [rows, columns] : {std::pair{4U, 4U}, {9U, 20U}, {11U, 34U}}) {
      const Joined list = as_colours(test::sheet(rows, columns, 500, damping));
      check_bits<float>(list, Arithmetic::separate);
      check_bits<double>(in_order(list, shuffled(list.x.size())), Arithmetic::contracted);
      check_bits<float>(with_faults(in_order(list, shuffled(list.x.size()))), Arithmetic::separate);
    }
    Joined rope = hanging({.springs = 37, .load = 1});
    std::get<Springs>(rope.scene.networks[0]).damping = damping;
    check_bits<float>(rope, Arithmetic::separate);
    check_bits<double>(rope, Arithmetic::separate);
    // A ring, and a rope hanging from it.
    std::get<Springs>(rope.scene.networks[0]).pairs.push_back({20, 0});
    check_bits<double>(rope, Arithmetic::separate);
  }
}

TEST_CASE("spring lines: a large sheet gives the same bits whatever the threads") {
  Joined joined = test::sheet(130, 128, 500);
  for (const Joined& large : {joined, as_colours(joined)}) {
    Joined swept = large;
    swept.scene.coupling = one_substep;
    const Run run{.isa = best_isa()};
    const Plan<float> plan = test::plan_of<float>(swept, run);
    const std::vector<float> wanted = stepped<float>(swept, plan, run, 1);
    for (const std::size_t threads : {2U, 3U}) {
      CHECK(test::difference(wanted, stepped<float>(swept, plan, {.isa = best_isa(), .threads = threads}, 1)) == "");
    }
  }
}

// ---- changes ----------------------------------------------------------------------------------------------------------------

TEST_CASE("spring lines: a plan torn, fixed, released and weighed anew in place steps as one made that way") {
  const Joined sheet = test::sheet(18, 21, 500);
  for (Joined joined : {sheet, test::as_list(sheet), as_colours(sheet), hanging({.load = 1})}) {
    joined.scene.coupling = one_substep;
    CAPTURE(joined.name);
    const std::uint32_t i = 9;
    test::Batch<double> changed(test::Layout::soa, joined.x.size());
    test::place(joined, changed.view());
    Plan<double> plan = test::plan_of(joined, {.isa = best_isa()}, changed.view());
    REQUIRE(plan.break_springs(0, std::vector<Pair>{{i + 4, i + 5}}).has_value());
    REQUIRE(plan.fix(i).has_value());
    REQUIRE(plan.release(0).has_value());
    REQUIRE(plan.set_mass(i + 2, 0.5).has_value());
    REQUIRE(plan.step(changed.view(), 3) == StepResult::done);

    Joined made = joined;
    std::visit([&](auto& network) { network.broken.push_back({i + 4, i + 5}); }, made.scene.networks[0]);
    std::erase(made.scene.fixed, 0U);
    made.scene.fixed.push_back(i);
    std::sort(made.scene.fixed.begin(), made.scene.fixed.end());
    made.scene.mass.make_each(made.x.size());
    made.scene.mass.set(i + 2, 0.5);
    CHECK(test::difference(stepped<double>(made, {.isa = best_isa()}, 3), test::values_of(changed.view())) == "");
  }
}

TEST_CASE("spring lines: ropes and sheets in rows have them by default, and other nets do not") {
  const auto steps_as = [](Joined joined, Lines lines) {
    joined.scene.coupling = {.scheme = Scheme::sequential, .substeps = 1};
    const std::vector<double> by_default = stepped<double>(joined, {}, 2);
    joined.scene.coupling.lines = lines;
    return test::difference(by_default, stepped<double>(joined, {}, 2)) == "";
  };
  const Joined sheet = test::sheet(12, 20, 500);
  const Joined list = test::as_list(sheet);
  for (const Joined& in_rows : {sheet, list, hanging({})}) {
    CAPTURE(in_rows.name);
    CHECK(steps_as(in_rows, Lines::whole));
    CHECK_FALSE(steps_as(in_rows, Lines::none));
  }
  const Joined across = test::with_spring_across(list);
  CHECK(steps_as(across, Lines::none));
  CHECK_FALSE(steps_as(across, Lines::whole));
}

TEST_CASE("spring lines: forward sweeps and theta have none, and a scene that asks for none steps otherwise") {
  Joined joined = test::sheet(12, 20, 500);
  for (const Coupling& coupling : {Coupling{.scheme = Scheme::sequential, .sweeps = SweepOrder::forward, .lines = Lines::whole},
                                   Coupling{.scheme = Scheme::sequential, .theta = 0.7, .lines = Lines::whole}}) {
    joined.scene.coupling = coupling;
    const std::vector<double> with = stepped<double>(joined, {}, 2);
    joined.scene.coupling.lines = Lines::none;
    CHECK(test::difference(with, stepped<double>(joined, {}, 2)) == "");
  }
  joined.scene.coupling = one_substep;
  const std::vector<double> with = stepped<double>(joined, {}, 2);
  joined.scene.coupling = without_lines;
  CHECK(test::difference(with, stepped<double>(joined, {}, 2)) != "");
}

}  // namespace spring_lines_test
