// Changes of a plan while it runs: a sheet of 64x64 at 5 sub-steps, one thread. `of_step` is the time of a change divided by
// that of one step, both measured in the same run; `bar` is its upper limit.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/plan.hpp"
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/starts.hpp"

namespace dvdx::bench {
namespace {

constexpr std::size_t side = sheet_side;
enum class Form { grid, list };

Scene sheet(Scheme scheme, Form form) {
  Scene scene = hung_sheet(scheme);
  scene.add(Sphere{.center = {1, -1, 1}, .radius = 0.5, .friction = 0.3});
  if (form == Form::list) scene.networks[0] = springs_of(std::get<Grid>(scene.networks[0]));
  scene.coupling.substeps = 5;
  return scene;
}

constexpr std::size_t most_changes = (side - 2) * (side - 2);  // each inner particle has changed once
constexpr double step = 1.0 / 480;                             // s: with 5 sub-steps, leapfrog is stable in any position

using Clock = std::chrono::steady_clock;

// s: the shortest of several runs.
template <class Work>
double shortest(int rounds, const Work& work) {
  double least = 1;
  for (int round = 0; round < rounds; ++round) {
    const auto from = Clock::now();
    work();
    least = std::min(least, std::chrono::duration<double>(Clock::now() - from).count());
  }
  return least;
}

// change(plan, n) makes the n-th change of a run. At the end the plan must step as one compiled anew.
template <class Change>
void time_change(benchmark::State& timing, const Scene& scene, double bar, const Change& change) {
  Held<float> held = hung();
  auto plan = compile<float>(scene, {.step = step}, held.state);
  if (!plan) return timing.SkipWithError(plan.error().message().c_str());
  const double of_step = shortest(20, [&] { (void)plan->step(held.state); });
  std::size_t n = 0;
  double least = 1;
  for (auto _ : timing) {
    const auto from = Clock::now();
    const auto changed = change(*plan, n++);
    const double passed = std::chrono::duration<double>(Clock::now() - from).count();
    if (!changed) timing.SkipWithError(changed.error().message().c_str());
    if (n <= most_changes) least = std::min(least, passed);
  }
  timing.counters["of_step"] = least / of_step;
  timing.counters["bar"] = bar;
  const Held<float> start = hung();
  Held<float> by_plan = hung();
  Held<float> by_other = hung();
  const auto anew =
      compile<float>(plan->scene(), {.step = plan->step_size(), .longest_step = plan->longest_step()}, start.state);
  (void)plan->step(by_plan.state, 3);
  if (!anew || anew->step(by_other.state, 3) != StepResult::done || state_hash(by_plan.state) != state_hash(by_other.state)) {
    timing.SkipWithError("the plan differs from one compiled anew");
  }
}

// The index of the sheet's n-th inner particle, cyclically.
std::size_t inner(std::size_t n) { return (1 + n / (side - 2) % (side - 2)) * side + 1 + n % (side - 2); }

void add_changes(const std::string& name, const Scene& scene) {
  const auto add_one = [&](const std::string& what, double bar, auto change) {
    add(Pace::timed, "change/" + what + "/" + name, [=](benchmark::State& timing) { time_change(timing, scene, bar, change); });
  };
  using P = Plan<float>;
  const auto sway = [](std::size_t n) { return 1e-3 * static_cast<double>(n % 2); };
  add_one("contact", 0.01, [=](P& plan, std::size_t n) {
    return plan.set_contact(0, Sphere{.center = {1, -1 + sway(n), 1}, .radius = 0.5, .friction = 0.3});
  });
  add_one("force", 0.05, [=](P& plan, std::size_t n) {
    return plan.set_force(0, Constant{.acceleration = {sway(n), -9.81, 0}});
  });
  add_one("step", 0.2, [=](P& plan, std::size_t n) { return plan.set_step(step * (1 - sway(n))); });
  add_one("stiffness", 0.5, [=](P& plan, std::size_t n) {
    const double k = 100 - sway(n);
    if (std::holds_alternative<Grid>(plan.scene().networks[0])) {
      return plan.set_stiffness(0, GridStiffness{.structural = k, .shear = k, .bend = k / 10});
    }
    return plan.set_stiffness(0, SpringsStiffness{.stiffness = k});
  });
  const auto* const springs = std::get_if<Springs>(&scene.networks[0]);
  if (springs != nullptr && scene.coupling.scheme == Scheme::leapfrog) {
    add_one("zero_length", 2.5, [=, pairs = springs->pairs.size()](P& plan, std::size_t n) {
      return plan.set_zero_length(0, std::vector<double>(pairs, sway(n)));
    });
  }
  add_one("mass", 0.05, [=](P& plan, std::size_t n) { return plan.set_mass(inner(n), (1.5 + sway(n)) / (side * side)); });
  add_one("fix_and_release", 0.1, [=](P& plan, std::size_t n) {
    const auto fixed = plan.fix(inner(n));
    return fixed ? plan.release(inner(n)) : fixed;
  });
  add_one("break", 0.05, [=](P& plan, std::size_t n) -> Expected<void> {
    const auto i = static_cast<std::uint32_t>(inner(n));
    if (n >= most_changes) return {};  // all of them are torn
    return plan.break_spring(0, {i, i + 1});
  });
}

// Times making the whole plan, for one more state or from nothing, relative to one step.
template <class Make>
void time_plan(benchmark::State& timing, const Scene& scene, double bar, const Make& make, double h = step) {
  Held<float> held = hung();
  const Held<float> start = hung();
  auto plan = compile<float>(scene, {.step = h}, start.state);
  const double of_step = shortest(20, [&] { (void)plan->step(held.state); });
  double least = 1;
  for (auto _ : timing) least = std::min(least, shortest(1, [&] { make(*plan, scene, start.state); }));
  timing.counters["of_step"] = least / of_step;
  timing.counters["bar"] = bar;
}

}  // namespace

void register_change() {
  for (const auto& [name, scheme] : {std::pair{"leapfrog", Scheme::leapfrog}, std::pair{"sequential", Scheme::sequential}}) {
    for (const auto& [form_name, form] : {std::pair{"grid", Form::grid}, std::pair{"list", Form::list}}) {
      const Scene scene = sheet(scheme, form);
      const std::string of = std::string(form_name) + "/" + name;
      add_changes(of, scene);
      add(Pace::timed, "change/clone/" + of, [=](benchmark::State& timing) {
        time_plan(timing, scene, 0.5,
                  [](const Plan<float>& plan, const Scene&, const State<float>&) { benchmark::DoNotOptimize(plan.clone()); });
      });
      Scene by_frames = scene;  // with the sub-steps of a whole frame
      by_frames.coupling.substeps.reset();
      add(Pace::timed, "change/check/" + of, [=](benchmark::State& timing) {
        const auto check = [](const Plan<float>& plan, const Scene&, const State<float>& state) {
          benchmark::DoNotOptimize(plan.check(state));
        };
        time_plan(timing, by_frames, 0.1, check, 1.0 / 60);
      });
      add(Pace::timed, "change/compile/" + of, [=](benchmark::State& timing) {
        time_plan(timing, scene, 20, [](const Plan<float>&, const Scene& anew, const State<float>& start) {
          benchmark::DoNotOptimize(compile<float>(anew, {.step = step}, start));
        });
      });
    }
  }
}

}  // namespace dvdx::bench
