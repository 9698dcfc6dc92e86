// The data that a plan carries beside the state: moved from one plan into another, they give the same bits.
#include <doctest/doctest.h>

#include <array>
#include <limits>
#include <vector>

#include "dvdx/dvdx.h"
#include "dvdx/layouts/convert.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "support/batch.hpp"
#include "support/isas.hpp"

namespace carried_test {

using namespace dvdx;
using test::Batch;
using test::Joined;
using test::Layout;

// Sweeps that carry the springs' accelerations, for a grid and for lists: in colours, and as a sheet whose particles are
// numbered in any order.
std::vector<Joined> sweeps() {
  std::vector<Joined> scenes;
  Joined grid = test::sheet(9, 14, 50, 0.001);
  grid.scene.coupling = {.scheme = Scheme::sequential};
  scenes.push_back(grid);
  scenes.push_back(test::as_list(grid));
  Joined wide = test::sheet(9, 35, 50, 0.001);
  wide.scene.coupling = {.scheme = Scheme::sequential};
  scenes.push_back(test::in_order(test::as_list(wide), test::shuffled(wide.x.size())));
  return scenes;
}

// Steps 7 times, moves the state into another plan with or without the carried data, and returns the hash after further steps.
template <class T>
std::uint64_t gone_on(const Joined& joined, Isa isa, Isa other, bool is_carried) {
  Batch<T> start(Layout::soa, joined.x.size()), first(Layout::soa, joined.x.size()), second(Layout::aos, joined.x.size());
  test::place(joined, start.view());
  test::place(joined, first.view());
  const Plan<T> plan = test::plan_of(joined, {.isa = isa}, start.view());
  REQUIRE(plan.step(first.view(), 7) == StepResult::done);
  const std::vector<double> carried = plan.carried(first.view());
  copy(first.view(), second.view());
  Plan<T> next = test::plan_of(joined, {.isa = other}, start.view());
  if (is_carried) REQUIRE(next.restore(carried, second.view()).has_value());
  REQUIRE(next.step(second.view(), 9) == StepResult::done);
  return state_hash(second.view());
}

template <class T>
std::uint64_t never_stopped(const Joined& joined) {
  Batch<T> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  const Plan<T> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
  REQUIRE(plan.step(batch.view(), 16) == StepResult::done);
  return state_hash(batch.view());
}

TEST_CASE_TEMPLATE(
    "sweeps go on in another plan with the same bits on any instruction set, but not without the carried numbers", T, float,
    double) {
  for (const Joined& joined : sweeps()) {
    CAPTURE(joined.name);
    const auto expected = never_stopped<T>(joined);
    for (const Isa isa : available_isas(Arithmetic::separate)) {
      CHECK(gone_on<T>(joined, isa, best_isa(), true) == expected);
      CHECK(gone_on<T>(joined, best_isa(), isa, true) == expected);
    }
    CHECK(gone_on<T>(joined, best_isa(), best_isa(), false) != expected);
  }
}

TEST_CASE("a workspace of the caller's is stored and restored as the plan's own") {
  const Joined joined = sweeps().front();
  Batch<float> start(Layout::soa, joined.x.size()), batch(Layout::soa, joined.x.size());
  test::place(joined, start.view());
  test::place(joined, batch.view());
  const Plan<float> plan = test::plan_of(joined, {.isa = best_isa()}, start.view());
  Workspace<float> workspace = plan.workspace();
  REQUIRE(plan.step(batch.view(), workspace, 7) == StepResult::done);
  const auto carried = plan.carried(batch.view(), workspace);
  CHECK(carried.size() == 1 + 3 * joined.x.size());
  CHECK(plan.carried(batch.view()).size() == 1);  // the plan's own workspace has not stepped this state
  Workspace<float> other = plan.workspace();
  REQUIRE(plan.restore(carried, batch.view(), other).has_value());
  REQUIRE(plan.step(batch.view(), other, 9) == StepResult::done);
  CHECK(state_hash(batch.view()) == never_stopped<float>(joined));
}

TEST_CASE("a state of another count, or a workspace of another scene, carries nothing on") {
  const Joined joined = sweeps().front(), small = test::sheet(3, 4, 50);
  Batch<float> batch(Layout::soa, joined.x.size()), of_small(Layout::soa, small.x.size());
  test::place(joined, batch.view());
  test::place(small, of_small.view());
  const Plan<float> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
  const Plan<float> other = test::plan_of(small, {.isa = best_isa()}, of_small.view());
  REQUIRE(plan.step(batch.view(), 3) == StepResult::done);
  CHECK(plan.carried(batch.view()).size() == 1 + 3 * joined.x.size());
  State<float> fewer = batch.view();
  fewer.count = 7;
  CHECK(plan.carried(fewer) == std::vector<double>{0});
  CHECK(plan.carried(batch.view(), other.workspace()).empty());
}

TEST_CASE("driven particles keep begun and waiting targets in the plan that goes on") {
  Joined joined = test::sheet(5, 6, 50, 0.001);
  joined.scene.coupling = {.scheme = Scheme::leapfrog};
  joined.scene.motions = {{.keys = {{.time = 0}}}};
  joined.scene.fixed.clear();
  joined.scene.kinematic = {{.particles = {0, 5}, .motion = 0}};
  Batch<double> start(Layout::soa, joined.x.size()), one(Layout::soa, joined.x.size()), two(Layout::soa, joined.x.size());
  for (auto* batch : {&start, &one, &two}) test::place(joined, batch->view());
  Plan<double> plan = test::plan_of(joined, {.isa = best_isa()}, start.view());
  Plan<double> next = test::plan_of(joined, {.isa = best_isa()}, start.view());
  REQUIRE(plan.set_pose(0, {.translation = {0.01, 0, 0}, .rotation = {0, 0.1, 0}}).has_value());
  REQUIRE(plan.step(one.view(), 3) == StepResult::done);
  REQUIRE(plan.set_places(0, std::vector<Vec3>{{0, 0.1, 0}, {1, 0.1, 0}}).has_value());  // requested, but not begun
  copy(one.view(), two.view());
  REQUIRE(next.restore(plan.carried(one.view()), two.view()).has_value());
  REQUIRE(plan.step(one.view(), 4) == StepResult::done);
  REQUIRE(next.step(two.view(), 4) == StepResult::done);
  CHECK(state_hash(one.view()) == state_hash(two.view()));
  CHECK(plan.carried(one.view()) == next.carried(two.view()));
}

TEST_CASE("numbers that are not of this plan are refused and change nothing") {
  const Joined joined = sweeps().front();
  Batch<float> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  Plan<float> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
  REQUIRE(plan.step(batch.view(), 7) == StepResult::done);
  const auto carried = plan.carried(batch.view());
  auto longer = carried;
  longer.push_back(0);
  auto no_flag = carried;
  no_flag[0] = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::vector<double>> wrong{{}, {1}, {carried.begin(), carried.end() - 1}, longer, no_flag};
  for (const auto& numbers : wrong) {
    const auto result = plan.restore(numbers, batch.view());
    REQUIRE(!result.has_value());
    CHECK(result.error().field == "carried");
  }
  REQUIRE(plan.step(batch.view(), 9) == StepResult::done);
  CHECK(state_hash(batch.view()) == never_stopped<float>(joined));
}

// Four particles in a swept sheet, through C.
struct ByC {
  ByC() {
    REQUIRE(dvdx_scene_create(DVDX_ABI_VERSION, &scene, &error) == DVDX_DONE);
    dvdx_grid grid{};
    grid.rows = grid.columns = 2;
    grid.edge_u[0] = grid.edge_v[2] = 1;
    grid.structural = 10;
    REQUIRE(dvdx_scene_add_grid(scene, &grid, &error) == DVDX_DONE);
    dvdx_coupling coupling{};
    coupling.scheme = DVDX_SEQUENTIAL;
    REQUIRE(dvdx_scene_set_coupling(scene, &coupling, &error) == DVDX_DONE);
    options.step = 0.01;
    options.precision = DVDX_FLOAT64;
  }
  ByC(const ByC&) = delete;
  ByC& operator=(const ByC&) = delete;
  ~ByC() { dvdx_scene_destroy(scene); }

  dvdx_scene* scene = nullptr;
  dvdx_options options{};
  dvdx_error error{};
};

TEST_CASE("carried numbers go on in another plan by C, and wrong arguments are refused") {
  ByC c;
  std::array<std::array<double, 4>, 6> start{{{0, 1.1, 0, 1}, {0, 0, 0.2, 0}, {0, 0, 1, 1.3}, {}, {}, {}}};
  const auto view = [](auto& of) {
    return dvdx_soa(DVDX_FLOAT64, of[0].data(), of[1].data(), of[2].data(), of[3].data(), of[4].data(), of[5].data(), 4);
  };
  auto one = start;
  dvdx_state flat = view(start), state = view(one);
  dvdx_plan *plan = nullptr, *next = nullptr;
  REQUIRE(dvdx_plan_create(c.scene, &c.options, &flat, &plan, &c.error) == DVDX_DONE);
  REQUIRE(dvdx_plan_create(c.scene, &c.options, &flat, &next, &c.error) == DVDX_DONE);
  REQUIRE(dvdx_plan_step(plan, &state, 5, nullptr, &c.error) == DVDX_DONE);

  std::size_t count = 0;
  REQUIRE(dvdx_plan_carried(plan, &state, nullptr, 0, &count, &c.error) == DVDX_DONE);
  REQUIRE(count == 13);
  std::vector<double> numbers(count, -7);
  REQUIRE(dvdx_plan_carried(plan, &state, numbers.data(), 3, &count, &c.error) == DVDX_DONE);
  CHECK(numbers[3] == -7);  // only three were allowed
  REQUIRE(dvdx_plan_carried(plan, &state, numbers.data(), count, &count, &c.error) == DVDX_DONE);
  auto two = one;
  dvdx_state other = view(two);
  other.clock = state.clock;
  CHECK(dvdx_plan_restore(next, numbers.data(), count - 1, &other, &c.error) == DVDX_INVALID);
  REQUIRE(dvdx_plan_restore(next, numbers.data(), count, &other, &c.error) == DVDX_DONE);
  CHECK(dvdx_plan_step(plan, &state, 5, nullptr, &c.error) == DVDX_DONE);
  CHECK(dvdx_plan_step(next, &other, 5, nullptr, &c.error) == DVDX_DONE);
  CHECK(one == two);

  CHECK(dvdx_plan_carried(nullptr, &state, nullptr, 0, &count, &c.error) != DVDX_DONE);
  CHECK(dvdx_plan_carried(plan, nullptr, nullptr, 0, &count, &c.error) != DVDX_DONE);
  CHECK(dvdx_plan_carried(plan, &state, nullptr, 1, &count, &c.error) != DVDX_DONE);
  CHECK(dvdx_plan_carried(plan, &state, nullptr, 0, nullptr, &c.error) != DVDX_DONE);
  CHECK(dvdx_plan_restore(plan, nullptr, 1, &state, &c.error) != DVDX_DONE);
  dvdx_plan_destroy(plan);
  dvdx_plan_destroy(next);
}

}  // namespace carried_test
