// Sequential without theta: second order with every other force, no heat in crumpling cloth, and the data carried from step to
// step.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"

namespace generalized_alpha_test {

using namespace dvdx;
using test::Batch;
using test::Joined;
using test::Layout;
using test::plan_of;
using test::stepped;

// A flat sheet held by two corners and released.
struct Sheet {
  std::size_t rows = 12;
  double side = 0.8, mass = 0.2;                       // m, kg
  double structural = 2000, shear = 1000, bend = 200;  // N/m
  double damping = 0;                                  // kg/s
};

Joined falling(const Sheet& sheet) {
  Joined joined;
  joined.name = std::to_string(sheet.rows) + " x " + std::to_string(sheet.rows);
  joined.step = 0.02;
  const double apart = sheet.side / static_cast<double>(sheet.rows - 1);
  for (std::size_t i = 0; i < sheet.rows * sheet.rows; ++i) {
    joined.x.push_back({apart * static_cast<double>(i % sheet.rows), 0, apart * static_cast<double>(i / sheet.rows)});
    joined.v.push_back({0, 0, 0});
  }
  joined.scene.mass = sheet.mass / static_cast<double>(sheet.rows * sheet.rows);
  joined.scene.fixed = {0, sheet.rows - 1};
  joined.scene.coupling.scheme = Scheme::sequential;
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  joined.scene.add(Network(Grid{.rows = sheet.rows,
                                .columns = sheet.rows,
                                .edge_u = {sheet.side, 0, 0},
                                .edge_v = {0, 0, sheet.side},
                                .structural = sheet.structural,
                                .shear = sheet.shear,
                                .bend = sheet.bend,
                                .damping = sheet.damping}));
  return joined;
}

std::array<Joined, 2> both_forms(const Joined& joined) { return {joined, test::as_list(joined)}; }

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); i += 6) {
    for (std::size_t axis = 0; axis < 3; ++axis) sum += (a[i + axis] - b[i + axis]) * (a[i + axis] - b[i + axis]);
  }
  return std::sqrt(6 * sum / static_cast<double>(a.size()));
}

double order_of(const std::vector<double>& coarse, const std::vector<double>& middle, const std::vector<double>& fine) {
  return std::log2(distance(coarse, middle) / distance(middle, fine));
}

template <class T>
std::unique_ptr<Batch<T>> placed(const Joined& joined) {
  auto batch = std::make_unique<Batch<T>>(Layout::soa, joined.x.size());
  test::place(joined, batch->view());
  return batch;
}

template <class T>
Plan<T> fast_plan(const Joined& joined) {
  return plan_of(joined, {.isa = best_isa()}, placed<T>(joined)->view());
}

template <class T>
void step(const Plan<T>& plan, Batch<T>& batch, std::size_t steps = 1) {
  REQUIRE(plan.step(batch.view(), steps) == StepResult::done);
}

// ---- order -------------------------------------------------------------------------------------------------------------

TEST_CASE("generalized alpha: the scheme is of second order with damping, drag and anchors" * doctest::test_suite("long")) {
  for (const bool has_more : {false, true}) {
    for (const double damping : {0.0, 0.02, 0.2, 1.0}) {
      Joined joined = falling({.rows = 8, .damping = damping});
      if (has_more) {
        const double mass = joined.scene.mass[0];
        joined.scene.add(Drag{.coefficient = 0.5 * mass, .wind = {1, 0, 2}});
        joined.scene.add(Spring{.stiffness = 400 * mass, .anchor = at_start});
      }
      const auto run = [&](int substeps) {
        joined.scene.coupling.substeps = substeps;
        return stepped<double>(joined, {.isa = best_isa()}, 6);
      };
      const double order = order_of(run(320), run(640), run(1280));
      CAPTURE(has_more);
      CAPTURE(damping);
      CHECK(std::abs(order - 2) < 0.2);
    }
  }
}

TEST_CASE("generalized alpha: second order holds with one sub-step a step and steps of changing size") {
  Joined joined = falling({.rows = 8, .damping = 1});
  joined.scene.coupling.substeps = 1;
  const auto run = [&](int parts) {
    Joined finer = joined;
    finer.step = 1.4 * 0.02 / parts;
    Plan<double> plan = fast_plan<double>(finer);
    auto batch = placed<double>(joined);
    for (int n = 0; n < 10 * parts; ++n) {
      REQUIRE(plan.set_step((n % 2 == 0 ? 0.6 : 1.4) * 0.02 / parts).has_value());
      step(plan, *batch);
    }
    return test::values_of(batch->view());
  };
  CHECK(std::abs(order_of(run(160), run(320), run(640)) - 2) < 0.2);
}

TEST_CASE("generalized alpha: a run there and back returns to the square of the step") {
  Joined joined = falling({.rows = 7});
  const auto miss = [&](int substeps) {
    joined.scene.coupling.substeps = substeps;
    Plan<double> plan = fast_plan<double>(joined);
    auto batch = placed<double>(joined);
    const auto start = test::values_of(batch->view());
    step(plan, *batch, 5);
    REQUIRE(plan.set_step(-joined.step).has_value());
    step(plan, *batch, 5);
    return distance(start, test::values_of(batch->view()));
  };
  const double coarse = miss(200);
  CHECK(coarse < 1e-4);
  CHECK(miss(400) < coarse / 3.5);
}

// ---- heat --------------------------------------------------------------------------------------------------------------

struct Energies {
  double kinetic, height;  // J; height: potential energy of the weight
};

template <class T>
Energies energies(const Joined& joined, State<T>& state) {
  Energies sum{0, 0};
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto v = static_cast<double>(state.v[axis][i]);
      sum.kinetic += 0.5 * joined.scene.mass[i] * v * v;
    }
    sum.height += joined.scene.mass[i] * 9.81 * static_cast<double>(state.x[1][i]);
  }
  return sum;
}

// The largest kinetic energy, relative to the start's plus the most that gravity has given.
double heat(const Joined& joined, std::size_t frames) {
  const Plan<float> plan = fast_plan<float>(joined);
  auto batch = placed<float>(joined);
  const Energies start = energies(joined, batch->view());
  double given = 0;
  double worst = 0;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    step(plan, *batch);
    const Energies now = energies(joined, batch->view());
    given = std::max(given, start.height - now.height);
    worst = std::max(worst, now.kinetic / (start.kinetic + given));
    if (!std::isfinite(now.kinetic)) return now.kinetic;
  }
  return worst;
}

Joined crumpling(std::size_t rows, double k, double kick, std::optional<double> theta) {
  Joined joined = falling({.rows = rows, .side = 2, .mass = 1, .structural = k, .shear = k, .bend = 0});
  joined.step = 1.0 / 60;
  joined.scene.coupling.theta = theta;
  for (std::size_t i = 0; i < joined.v.size(); ++i) {
    if (i == 0 || i + 1 == rows) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) joined.v[i][axis] = (kick + 1e-6) * test::scatter(i, axis);
  }
  return joined;
}

TEST_CASE("generalized alpha: cloth that crumples never moves with more than it was given") {
  std::size_t turn = 0;  // grids and lists take turns, so that each meets every value of the other parameters
  for (const double k : {1e2, 1e4, 1e6}) {
    for (const int substeps : {1, 2}) {
      for (const double kick : {0.0, 10.0}) {
        for (const bool has_floor : {false, true}) {
          Joined grid = crumpling(kick == 0 ? 32 : 16, k, kick, std::nullopt);
          grid.scene.coupling.substeps = substeps;
          if (has_floor) grid.scene.add(Plane{.normal = {0, 1, 0}, .offset = -1, .restitution = 0.8});
          const Joined joined = (turn + turn / 2 + turn / 4 + turn / 8) % 2 == 0 ? grid : test::as_list(grid);
          ++turn;
          CAPTURE(joined.name);
          CAPTURE(k);
          CAPTURE(substeps);
          CAPTURE(kick);
          CAPTURE(has_floor);
          CHECK(heat(joined, 150) <= 1.3);
        }
      }
    }
  }
}

TEST_CASE("generalized alpha: the same cloth heats at theta 0.55") {
  Joined joined = crumpling(32, 1e6, 0, 0.55);
  joined.scene.coupling.substeps = 2;
  CHECK_FALSE(heat(joined, 150) <= 1.3);
}

TEST_CASE("generalized alpha: cloth stays calm where every step starts anew") {
  Joined joined = crumpling(32, 1e4, 0, std::nullopt);
  joined.scene.coupling.substeps = 1;
  Plan<float> plan = fast_plan<float>(joined);
  auto batch = placed<float>(joined);
  const Energies start = energies(joined, batch->view());
  for (std::size_t frame = 0; frame < 200; ++frame) {
    plan.forget();
    step(plan, *batch);
    CHECK(energies(joined, batch->view()).kinetic < 1.3 * 9.81);  // half of the weight times the side
  }
  CHECK(energies(joined, batch->view()).height < start.height - 5);
}

// ---- memory ------------------------------------------------------------------------------------------------------------

TEST_CASE_TEMPLATE(
    "generalized alpha: n steps in one call are n calls, through a call of no steps, a step of 0 s and a moved plan", T, float,
    double) {
  for (const double damping : {0.0, 0.02}) {
    for (Joined joined : both_forms(falling({.damping = damping}))) {
      CAPTURE(joined.name);
      joined.scene.coupling.substeps = 2;
      Plan<T> plan = fast_plan<T>(joined);
      const Plan<T> other = plan.clone();
      auto at_once = placed<T>(joined);
      auto one_by_one = placed<T>(joined);
      step(plan, *at_once, 12);
      for (int n = 0; n < 6; ++n) step(other, *one_by_one);
      step(other, *one_by_one, 0);
      for (int n = 0; n < 6; ++n) step(other, *one_by_one);
      CHECK(test::values_of(at_once->view()) == test::values_of(one_by_one->view()));

      REQUIRE(plan.set_step(0).has_value());
      step(plan, *at_once, 3);
      REQUIRE(plan.set_step(joined.step).has_value());
      Plan<T> moved = std::move(plan);
      step(moved, *at_once, 3);
      step(other, *one_by_one, 3);
      CHECK(test::values_of(at_once->view()) == test::values_of(one_by_one->view()));
    }
  }
}

TEST_CASE("generalized alpha: a workspace of the caller's remembers for itself") {
  const Joined joined = falling({});
  const Plan<double> plan = fast_plan<double>(joined);
  Workspace<double> workspace = plan.workspace();
  auto by_plan = placed<double>(joined);
  auto by_workspace = placed<double>(joined);
  for (int n = 0; n < 8; ++n) {
    step(plan, *by_plan);
    REQUIRE(plan.step(by_workspace->view(), workspace) == StepResult::done);
  }
  CHECK(test::values_of(by_plan->view()) == test::values_of(by_workspace->view()));
  workspace.forget();
  step(plan, *by_plan);
  REQUIRE(plan.step(by_workspace->view(), workspace) == StepResult::done);
  CHECK(test::values_of(by_plan->view()) != test::values_of(by_workspace->view()));
}

TEST_CASE("generalized alpha: the memory is dropped by forget(), for another state and for another time") {
  Joined joined = falling({.damping = 0.02});
  joined.step = 1.0 / 64;  // no clock rounds it
  const Plan<double> plan = fast_plan<double>(joined);
  // Two steps of a state by a fresh plan.
  const auto anew = [&](Batch<double>& from) {
    auto copy = placed<double>(joined);
    for (std::size_t i = 0; i < copy->view().count; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        copy->view().x[axis][i] = from.view().x[axis][i];
        copy->view().v[axis][i] = from.view().v[axis][i];
      }
    }
    copy->view().clock = from.view().clock;
    step(plan.clone(), *copy, 2);
    return test::values_of(copy->view());
  };
  enum class Change { none, forgotten, another_state_between, another_time };
  for (const Change change : {Change::none, Change::forgotten, Change::another_state_between, Change::another_time}) {
    Plan<double> stepping = plan.clone();
    auto batch = placed<double>(joined);
    step(stepping, *batch, 9);
    if (change == Change::forgotten) stepping.forget();
    if (change == Change::another_state_between) {
      auto between = placed<double>(joined);
      step(stepping, *between, 9);
    }
    if (change == Change::another_time) batch->view().clock.advance(1, 1);
    const auto wanted = anew(*batch);
    step(stepping, *batch, 2);
    CHECK((test::values_of(batch->view()) == wanted) == (change != Change::none));
  }
}

TEST_CASE_TEMPLATE("generalized alpha: a bad particle that is mended goes on", T, float, double) {
  for (const Joined& joined : both_forms(falling({.damping = 0.02}))) {
    const Plan<T> plan = fast_plan<T>(joined);
    auto batch = placed<T>(joined);
    State<T>& state = batch->view();
    step(plan, *batch, 5);
    const T x = state.x[1][40];
    state.x[1][40] = std::numeric_limits<T>::quiet_NaN();
    state.v[2][41] = std::numeric_limits<T>::infinity();
    step(plan, *batch, 5);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const std::size_t i : {std::size_t{40}, std::size_t{41}}) {
        state.x[axis][i] = static_cast<T>(joined.x[i][axis]) + (axis == 1 ? x : T(0));
        state.v[axis][i] = 0;
      }
    }
    step(plan, *batch, 5);
    for (const T value : test::values_of(state)) CHECK(std::isfinite(value));
  }
}

// 1e14 m in 1e-13 s.
TEST_CASE("generalized alpha: an acceleration that is beyond float32 is not remembered") {
  Joined joined;
  joined.name = "rope";
  joined.step = 1e-13;
  joined.scene.coupling = {.scheme = Scheme::sequential, .substeps = 1, .lines = Lines::none};  // lines would carry it on
  joined.scene.add(Network(Grid{.rows = 2, .columns = 17, .edge_u = {16, 0, 0}, .edge_v = {0, 1, 0}, .structural = 1e26}));
  for (std::size_t i = 0; i < 34; ++i) joined.x.push_back({static_cast<double>(i % 17), static_cast<double>(i / 17), 0});
  joined.v.resize(34);
  for (const Joined& of : both_forms(joined)) {
    const Plan<float> plan = fast_plan<float>(of);
    auto batch = placed<float>(of);
    batch->view().x[0][1] = 1e14F;
    step(plan, *batch);
    CHECK_FALSE(std::isfinite(batch->view().v[0][1]));
    test::place(of, batch->view());
    step(plan, *batch);
    for (const float value : test::values_of(batch->view())) CHECK(std::isfinite(value));
  }
}

TEST_CASE("generalized alpha: a scene with theta has no memory to pay for") {
  Joined joined = falling({});
  const std::size_t with = fast_plan<float>(joined).workspace().bytes();
  joined.scene.coupling.theta = 0.5;
  const std::size_t without = fast_plan<float>(joined).workspace().bytes();
  CHECK(with - without >= 3 * sizeof(float) * joined.x.size());
  joined.scene.coupling = {.scheme = Scheme::sequential, .sweeps = SweepOrder::forward};
  CHECK(fast_plan<float>(joined).workspace().bytes() < without);
}

}  // namespace generalized_alpha_test
