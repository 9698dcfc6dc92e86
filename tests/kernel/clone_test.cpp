// A plan, its clones and workspaces: shared and separate data, and simultaneous steps on threads.
#include <doctest/doctest.h>

#include <array>
#include <barrier>
#include <cstddef>
#include <string>
#include <thread>
#include <vector>

#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "kernel/passes/joined_run.hpp"
#include "plan/plan_parts.hpp"
#include "support/batch.hpp"
#include "support/scenes.hpp"

namespace clone_test {

using namespace dvdx;
using test::Batch;
using test::Joined;
using test::Layout;

// One scene for each form of a network, and for constraints.
std::vector<Joined> joined_scenes() {
  std::vector<Joined> scenes;
  const std::array<Coupling, 4> couplings{{{.scheme = Scheme::leapfrog},
                                           {.scheme = Scheme::fourth_order},
                                           {.scheme = Scheme::sequential},
                                           {.scheme = Scheme::accumulate}}};
  for (const Coupling& coupling : couplings) {
    Joined grid = test::sheet(9, 14, 50, 0.001);
    grid.scene.coupling = coupling;
    grid.name += ", scheme " + std::to_string(static_cast<int>(coupling.scheme));
    scenes.push_back(grid);
    Joined list = test::as_list(grid);
    list.scene.add(Constraint(Distance{.pairs = {{40, 41}, {41, 42}, {60, 74}}}));
    scenes.push_back(list);
  }
  return scenes;
}

// Gives each state its own start: the scene's, shifted.
template <class T>
void place_shifted(const Joined& joined, State<T>& state, double shift) {
  test::place(joined, state);
  for (std::size_t i = 0; i < state.count; ++i) state.v[0][i] += static_cast<T>(shift);
}

template <class T>
Plan<T> plan_alone(const Joined& joined) {
  return test::plan_of<T>(joined, {.isa = best_isa()});
}

template <class T>
std::uint64_t hash_alone(const Joined& joined, Plan<T>& plan, double shift, std::size_t steps) {
  Batch<T> batch(Layout::soa, joined.x.size());
  place_shifted(joined, batch.view(), shift);
  plan.forget();
  REQUIRE(plan.step(batch.view(), steps) == StepResult::done);
  return state_hash(batch.view());
}

TEST_CASE_TEMPLATE("clone: two threads step two states of one scene at once, with the bits of each alone", T, float, double) {
  constexpr std::size_t steps = 60;
  for (const Joined& joined : joined_scenes()) {
    CAPTURE(joined.name);
    Batch<T> scene(Layout::soa, joined.x.size());
    test::place(joined, scene.view());
    const Plan<T> plan = test::plan_of(joined, {.isa = best_isa()}, scene.view());
    const Plan<T> clone = plan.clone();
    Workspace<T> workspace = plan.workspace();
    std::array<Batch<T>, 3> batches{Batch<T>(Layout::soa, joined.x.size()), Batch<T>(Layout::soa, joined.x.size()),
                                    Batch<T>(Layout::soa, joined.x.size())};
    for (std::size_t k = 0; k < 3; ++k) place_shifted(joined, batches[k].view(), 0.1 * static_cast<double>(k));
    std::array<StepResult, 3> results{};
    std::barrier together(3);
    const auto in_thread = [&](const auto& step) {
      return std::thread([&together, step] {
        together.arrive_and_wait();
        step();
      });
    };
    std::thread first = in_thread([&] { results[0] = plan.step(batches[0].view(), steps); });
    std::thread second = in_thread([&] { results[1] = clone.step(batches[1].view(), steps); });
    std::thread third = in_thread([&] { results[2] = plan.step(batches[2].view(), workspace, steps); });
    first.join();
    second.join();
    third.join();
    Plan<T> alone = plan_alone<T>(joined);
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(results[k] == StepResult::done);
      CHECK(state_hash(batches[k].view()) == hash_alone(joined, alone, 0.1 * static_cast<double>(k), steps));
    }
  }
}

TEST_CASE("clone: a change of the plan leaves its clone as it was") {
  for (const Joined& joined : joined_scenes()) {
    CAPTURE(joined.name);
    Batch<double> scene(Layout::soa, joined.x.size()), batch(Layout::soa, joined.x.size());
    test::place(joined, scene.view());
    Plan<double> plan = test::plan_of(joined, {.isa = best_isa()}, scene.view());
    const Plan<double> clone = plan.clone();
    REQUIRE(plan.set_step(joined.step / 3).has_value());
    REQUIRE(plan.set_force(0, Constant{.acceleration = {1, 2, 3}}).has_value());
    CHECK(clone.step_size() == joined.step);
    Scene as_compiled = joined.scene;
    as_compiled.coupling.longest_substep = clone.scene().coupling.longest_substep;  // the plan's choice
    as_compiled.coupling.line_forces = clone.scene().coupling.line_forces;          // also the plan's choice
    CHECK(clone.scene() == as_compiled);
    place_shifted(joined, batch.view(), 0);
    REQUIRE(clone.step(batch.view(), 20) == StepResult::done);
    Plan<double> alone = plan_alone<double>(joined);
    CHECK(state_hash(batch.view()) == hash_alone(joined, alone, 0, 20));
  }
}

TEST_CASE("clone: a clone takes a workspace of memory, and none of the scene's") {
  const Joined joined = test::sheet(64, 64, 1000);
  for (const Scheme scheme : {Scheme::leapfrog, Scheme::sequential}) {
    Joined with = joined;
    with.scene.coupling.scheme = scheme;
    std::size_t bytes = 0;
    const auto allocate = [](void* context, std::size_t size, std::size_t boundary) {
      *static_cast<std::size_t*>(context) += size;
      return ::operator new (size, std::align_val_t{boundary}, std::nothrow);
    };
    const auto release = [](void*, void* memory, std::size_t, std::size_t boundary) {
      ::operator delete (memory, std::align_val_t{boundary});
    };
    Batch<float> batch(Layout::soa, with.x.size());
    test::place(with, batch.view());
    Options options{.step = with.step, .memory = {.allocate = allocate, .release = release, .context = &bytes}};
    const auto plan = compile<float>(with.scene, options, batch.view());
    REQUIRE(plan.has_value());
    const std::size_t of_workspace = plan->workspace().bytes();
    bytes = 0;
    const Plan<float> clone = plan->clone();
    CHECK(bytes + with.scene.fixed.size() * sizeof(PinnedState<float>) == of_workspace);
    // Positions and velocities of 4096 padded particles; sweeps add shifts, forces and distances of 24 000 springs.
    CHECK(bytes < (scheme == Scheme::leapfrog ? 250'000 : 900'000));
  }
}

TEST_CASE("clone: a workspace serves as long as its columns fit, and is refused by name when they do not") {
  const Joined joined = test::sheet(9, 14, 50);
  Batch<float> batch(Layout::soa, joined.x.size());
  test::place(joined, batch.view());
  Plan<float> plan = test::plan_of(joined, {.isa = best_isa()}, batch.view());
  Workspace<float> workspace = plan.workspace();
  CHECK(plan.step(batch.view(), workspace) == StepResult::done);
  REQUIRE(plan.set_step(joined.step / 2).has_value());
  CHECK(plan.step(batch.view(), workspace) == StepResult::done);

  const Joined other = test::sheet(20, 30, 50);
  Batch<float> of_other(Layout::soa, other.x.size());
  test::place(other, of_other.view());
  const Plan<float> other_plan = test::plan_of(other, {.isa = best_isa()}, of_other.view());
  const std::uint64_t before = state_hash(of_other.view());
  CHECK(other_plan.step(of_other.view(), workspace) == StepResult::workspace_differs);
  CHECK(state_hash(of_other.view()) == before);

  Scene falling;
  falling.add(Constant{.acceleration = {0, -9.81, 0}});
  const auto free = compile<float>(falling, {});
  REQUIRE(free.has_value());
  CHECK(free->workspace().bytes() == 0);
  CHECK(free->step(of_other.view(), workspace) == StepResult::done);
}

}  // namespace clone_test
