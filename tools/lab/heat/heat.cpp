#include "heat/heat.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/plan.hpp"
#include "state/engine.hpp"
#include "state/start.hpp"
#include "watch/energy_budget.hpp"

namespace dvdx::tool::stability {
namespace {

constexpr double beyond_doubt = 1e6;  // share of what was given; a run beyond it does not recover
// J: the energy that driven pins may leave in a sheet some 10 s after they came to rest, a tenth of its weight times its side
constexpr double most_left = 1;

template <class T>
HeatRun run_in(const Setting& setting, const Stepping& stepping, Isa isa, Arithmetic arithmetic) {
  const SceneFile file = scene_of(setting, stepping.coupling);
  Soa<T> memory(file.particles.count);
  State<T> state = memory.view();
  place_at_start(file, state);
  auto plan = compile<T>(file.scene, {.step = file.step, .isa = isa, .arithmetic = arithmetic}, state);
  if (!plan) throw std::runtime_error(plan.error().message());
  const auto limit = plan->network_limit().value_or(NetworkLimit{});
  HeatRun run{.stepping = stepping.name, .must_hold = stepping.must_hold, .setting = setting};
  run.z = limit.frequency * file.step / limit.substeps;
  EnergyBudget budget(file, state);
  while (run.frames < setting.frames) {
    if (setting.times != FrameTimes::even && !plan->set_step(frame_time(setting, run.frames))) {
      throw std::logic_error("the plan takes no such step");
    }
    if (plan->step(state, 1) != StepResult::done) throw std::logic_error("the plan is for another state");
    ++run.frames;
    budget.look(state);
    if (setting.drives_pins()) continue;
    const double share = budget.share();
    if (share <= run.share) continue;
    run.share = share;
    run.kinetic = budget.kinetic();
    run.given = budget.given();
    run.frame = run.frames;
    if (!(share < beyond_doubt)) break;
  }
  if (setting.drives_pins()) {
    run.frame = run.frames;
    run.kinetic = budget.kinetic();
    run.given = most_left / heat_bar;
    run.share = run.kinetic / run.given;
  }
  run.bits = state_hash(state);
  return run;
}

}  // namespace

std::vector<Stepping> steppings() {
  constexpr Scheme sequential = Scheme::sequential;
  return {{.name = "default", .coupling = {.scheme = sequential}, .must_hold = true},
          {.name = "theta 0.5", .coupling = {.scheme = sequential, .theta = 0.5}},
          {.name = "theta 0.55", .coupling = {.scheme = sequential, .theta = 0.55}},
          {.name = "theta 0.7", .coupling = {.scheme = sequential, .theta = 0.7}},
          {.name = "theta 1 forward", .coupling = {.scheme = sequential, .theta = 1, .sweeps = SweepOrder::forward}}};
}

HeatRun run_setting(const Setting& setting, const Stepping& stepping, Isa isa, Arithmetic arithmetic) {
  return setting.precision == Precision::float64 ? run_in<double>(setting, stepping, isa, arithmetic)
                                                 : run_in<float>(setting, stepping, isa, arithmetic);
}

std::vector<HeatRun> measure_heat(Ensemble ensemble, const Engine& engine, const TellHeat& tell) {
  const auto settings = settings_of(ensemble);
  const auto all_steppings = steppings();
  std::vector<HeatRun> runs(settings.size() * all_steppings.size());
  std::atomic<std::size_t> next = 0;
  std::mutex telling;
  std::size_t done = 0;
  std::exception_ptr failed;
  const auto work = [&] {
    for (std::size_t n = next++; n < runs.size(); n = next++) {
      try {
        runs[n] = run_setting(settings[n % settings.size()], all_steppings[n / settings.size()], engine.isa, engine.arithmetic);
      } catch (...) {
        const std::lock_guard lock(telling);
        failed = std::current_exception();
        next = runs.size();
      }
      const std::lock_guard lock(telling);
      tell(++done, runs.size());
    }
  };
  {
    std::vector<std::jthread> others;
    for (int thread = 1; thread < engine.threads; ++thread) others.emplace_back(work);
    work();
  }
  if (failed) std::rethrow_exception(failed);
  return runs;
}

bool all_calm(const std::vector<HeatRun>& runs) {
  return std::none_of(runs.begin(), runs.end(), [](const HeatRun& run) { return run.must_hold && run.is_hot(); });
}

}  // namespace dvdx::tool::stability
