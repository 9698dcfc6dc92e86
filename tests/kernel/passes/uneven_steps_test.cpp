// Steps that vary from frame to frame: bounded by energy, the same equilibrium for every step, and equal plans however they
// were made.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/batch.hpp"
#include "support/close.hpp"

namespace uneven_steps_test {

using namespace dvdx;
using test::Batch;
using test::Joined;
using test::Layout;

constexpr double hz60 = 1.0 / 60;

// s, the length of frame n
using Frames = std::function<double(std::size_t)>;

Frames in_turn(double first, double second) {
  return [=](std::size_t n) { return n % 2 == 0 ? first : second; };
}

// The fractional parts of the golden ratio's multiples cover the range evenly.
Frames scattered(double least, double most) {
  return [=](std::size_t n) {
    const double part = std::fmod(static_cast<double>(n) * (std::numbers::phi - 1), 1.0);
    return least + (most - least) * part;
  };
}

// Springs of 1 m between particles of 1 kg in a line, each displaced by at most 2 mm from rest.
Joined chain(std::size_t count, double stiffness) {
  Joined joined;
  joined.name = std::to_string(count) + " particles, " + std::to_string(stiffness) + " N/m";
  joined.scene.mass = 1.0;
  joined.scene.fixed = {0};
  Springs springs{.pairs = {}, .stiffness = stiffness, .rest_length = Scalars(1.0)};
  double y = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) {
      y -= 1;
      springs.pairs.push_back({static_cast<std::uint32_t>(i - 1), static_cast<std::uint32_t>(i)});
    }
    const double off = i == 0 ? 0 : 1e-3 * (static_cast<double>(i * 7 % 5) - 2);
    joined.x.push_back({0, y + off, 0});
    joined.v.push_back({0, 0, 0});
  }
  joined.scene.add(Network(springs));
  return joined;
}

// A hanging square sheet of 1 m and 0.2 kg, held by two corners.
Joined curtain(std::size_t rows, double stiffness) {
  Joined joined;
  joined.name = std::to_string(rows) + " rows, " + std::to_string(stiffness) + " N/m";
  const double apart = 1.0 / static_cast<double>(rows - 1);
  for (std::size_t i = 0; i < rows * rows; ++i) {
    joined.x.push_back({apart * static_cast<double>(i % rows), -apart * static_cast<double>(i / rows), 0});
    joined.v.push_back({0, 0, 0});
  }
  joined.scene.mass = 0.2 / static_cast<double>(rows * rows);
  joined.scene.fixed = {0, rows - 1};
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  joined.scene.add(Network(Grid{.rows = rows,
                                .columns = rows,
                                .edge_u = {1, 0, 0},
                                .edge_v = {0, -1, 0},
                                .structural = stiffness,
                                .shear = stiffness / 3,
                                .bend = stiffness / 100}));
  return joined;
}

Joined stepped_by(Joined joined, Scheme scheme, std::optional<int> substeps = std::nullopt) {
  joined.scene.coupling.scheme = scheme;
  joined.scene.coupling.substeps = substeps;
  return joined;
}

template <class T>
double fastest(const State<T>& state) {
  double most = 0;
  for (std::size_t i = 0; i < state.count; ++i) {
    double square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) square += double(state.v[axis][i]) * double(state.v[axis][i]);
    if (!(square <= most)) most = square;
  }
  return std::sqrt(most);
}

// m/s: the largest speed of any particle in any frame
template <class T>
double fastest_ever(const Joined& joined, const Frames& h, std::size_t frames, double compiled_for = hz60) {
  Batch<T> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  Joined first = joined;
  first.step = compiled_for;
  Plan<T> plan = test::plan_of(first, {.isa = best_isa()}, batch.view());
  double most = 0;
  for (std::size_t n = 0; n < frames; ++n) {
    REQUIRE(plan.set_step(h(n)).has_value());
    REQUIRE(plan.step(batch.view()) == StepResult::done);
    const double now = fastest(batch.view());
    if (!(now <= most)) most = now;
  }
  return most;
}

TEST_CASE("uneven steps: a chain that swings by 2 mm never moves faster than its energy allows" * doctest::test_suite("long")) {
  for (const std::size_t count : {2U, 3U, 7U, 20U}) {
    for (const double stiffness : {3e2, 3e3, 1e4, 3e5}) {
      for (const double ratio : {1.5, 2.0, 3.0, 4.0}) {
        for (const bool is_random : {false, true}) {
          const Joined joined = stepped_by(chain(count, stiffness), Scheme::sequential, 1);
          const Frames h = is_random ? scattered(0.003, 0.05) : in_turn(hz60, ratio * hz60);
          // Each spring stores at most k (4 mm)^2 / 2.
          const double allowed = 0.004 * std::sqrt(stiffness * static_cast<double>(count - 1));
          CAPTURE(joined.name);
          CAPTURE(ratio);
          CAPTURE(is_random);
          CHECK(fastest_ever<double>(joined, h, 300) <= 1.1 * allowed + 0.02);
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("uneven steps: a sheet that hangs down does not start to fly", T, float, double) {
  std::size_t turn = sizeof(T) == 4 ? 0 : 1;  // grids and lists take turns
  for (const std::size_t rows : {5U, 13U}) {
    for (const double stiffness : {500.0, 1e4}) {
      for (const Frames& h :
           {scattered(0.003, 0.05), in_turn(0.008, 0.033), Frames([](std::size_t n) { return n % 3 == 0 ? 0.033 : 0.017; })}) {
        const Joined joined = stepped_by(curtain(rows, stiffness), Scheme::sequential, 1);
        CAPTURE(joined.name);
        CHECK(fastest_ever<T>(turn++ % 2 == 0 ? joined : test::as_list(joined), h, 200) < 5);
      }
    }
  }
}

TEST_CASE("uneven steps: a hitch of 250 ms is cut, and nothing is faster after it") {
  const Joined joined = stepped_by(curtain(17, 1e4), Scheme::sequential, 1);
  const Frames hitches = [](std::size_t n) { return n % 60 == 59 ? 0.25 : hz60; };
  CHECK(fastest_ever<double>(joined, hitches, 300) < 5);
}

TEST_CASE("uneven steps: the rest does not depend on the step that is taken") {
  const Joined joined = stepped_by(curtain(7, 200), Scheme::sequential, 1);
  Joined drawn = joined;
  drawn.scene.add(Drag{.coefficient = 4 * drawn.scene.mass[0]});
  const auto lowest = [&](double h) {
    Batch<double> batch(Layout::soa, drawn.x.size());
    test::place(drawn, batch.view());
    auto plan = compile<double>(drawn.scene, {.step = h, .longest_step = hz60}, batch.view());
    REQUIRE(plan.has_value());
    const auto after = [&](double seconds) {
      REQUIRE(plan->step(batch.view(), static_cast<std::size_t>(seconds / h)) == StepResult::done);
      double y = 0;
      for (std::size_t i = 0; i < batch.view().count; ++i) y = std::min(y, batch.view().x[1][i]);
      return y;
    };
    const double y = after(8);
    CHECK(test::is_close(after(1), y, 1e-6));
    return y;
  };
  // Drag and springs act in turn, which moves the rest by the step's square. A separate T for each step would move it by a
  // tenth.
  const double y = lowest(hz60);
  for (const double h : {hz60 / 2, hz60 / 3}) CHECK(test::is_close(lowest(h), y, 2e-3));
}

TEST_CASE("uneven steps: a longer step takes as many sub-steps as stay below those of the longest step") {
  const Joined joined = stepped_by(chain(5, 1e4), Scheme::sequential, 2);
  Batch<double> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  Joined first = joined;
  first.step = hz60;
  Plan<double> plan = test::plan_of(first, {}, batch.view());
  CHECK_FALSE(plan.longest_step());
  struct Wanted {
    double step;
    int substeps;
  };
  for (const Wanted& wanted : {Wanted{hz60, 2}, {2 * hz60, 4}, {2.01 * hz60, 5}, {hz60 / 3, 2}, {-3 * hz60, 6}, {hz60, 2}}) {
    REQUIRE(plan.set_step(wanted.step).has_value());
    CAPTURE(wanted.step);
    CHECK(plan.network_limit()->substeps == wanted.substeps);
  }
  CHECK(plan.longest_step() == hz60);
  CHECK(plan.explain().find("steps vary") != std::string::npos);
}

TEST_CASE("uneven steps: a step that would take more than a million sub-steps of the longest one's length is refused") {
  for (Joined joined : {stepped_by(chain(5, 1e4), Scheme::sequential, 2), stepped_by(curtain(6, 300), Scheme::sequential, 2)}) {
    Batch<double> batch(Layout::soa, joined.x.size());
    test::place(joined, batch.view());
    joined.step = 0x1p-20;
    Plan<double> plan = test::plan_of(joined, {}, batch.view());
    for (const double h : {0.5, -0.5, 1e4}) {
      const auto changed = plan.set_step(h);
      REQUIRE_FALSE(changed.has_value());
      CHECK(changed.error().field == "step");
      CHECK(changed.error().valid ==
            "at most 0.4768 s: 1000000 sub-steps of 4.768e-07 s, those of a longest step of 9.537e-07 s");
      CHECK(plan.step_size() == joined.step);
    }
    REQUIRE(plan.set_step(-0.47).has_value());
    CHECK(plan.network_limit()->substeps == 985662);
  }
}

TEST_CASE_TEMPLATE("uneven steps: a plan is the same whether its step was changed in place, in a shared plan, or compiled so",
                   T, float, double) {
  Joined grid = stepped_by(curtain(20, 500), Scheme::sequential, 1);
  std::get<Grid>(grid.scene.networks[0]).damping = 0.01;
  Joined irregular = test::as_list(grid);
  auto& springs = std::get<Springs>(irregular.scene.networks[0]);
  springs.pairs.erase(springs.pairs.begin() + 30);
  springs.stiffness = 300.0;
  springs.rest_length.reset();
  for (Joined joined : {grid, test::as_list(grid), irregular}) {
    CAPTURE(joined.name);
    joined.step = hz60;
    Batch<T> start(Layout::soa, joined.x.size());
    test::place(joined, start.view());
    Plan<T> in_place = test::plan_of(joined, {.isa = best_isa()}, start.view());
    Plan<T> shared = test::plan_of(joined, {.isa = best_isa()}, start.view());
    Workspace<T> workspace = shared.workspace();
    Batch<T> a(Layout::soa, joined.x.size()), b(Layout::soa, joined.x.size()), c(Layout::soa, joined.x.size());
    for (Batch<T>* batch : {&a, &b, &c}) test::place(joined, batch->view());
    std::optional<Workspace<T>> compiled_workspace;
    for (const double h : {0.6 * hz60, 1.7 * hz60, 0.6 * hz60, hz60, 0.2 * hz60}) {
      const Plan<T> keeps_it_shared = shared.clone();
      REQUIRE(in_place.set_step(h).has_value());
      REQUIRE(shared.set_step(h).has_value());
      const auto anew = compile<T>(joined.scene, {.step = h, .longest_step = hz60, .isa = best_isa()}, start.view());
      REQUIRE(anew.has_value());
      if (!compiled_workspace) compiled_workspace.emplace(anew->workspace());
      REQUIRE(in_place.step(a.view(), 3) == StepResult::done);
      REQUIRE(shared.step(b.view(), workspace, 3) == StepResult::done);
      REQUIRE(anew->step(c.view(), *compiled_workspace, 3) == StepResult::done);
      CHECK(state_hash(a.view()) == state_hash(b.view()));
      CHECK(state_hash(a.view()) == state_hash(c.view()));
    }
  }
}

TEST_CASE("uneven steps: a longest step that is not positive and finite is refused by name") {
  const Joined joined = stepped_by(chain(3, 1e3), Scheme::sequential);
  Batch<double> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  for (const double wrong : {0.0, -hz60, HUGE_VAL}) {
    const auto plan = compile<double>(joined.scene, {.step = hz60, .longest_step = wrong}, batch.view());
    REQUIRE_FALSE(plan.has_value());
    CHECK(plan.error().field == "longest_step");
  }
}

}  // namespace uneven_steps_test
