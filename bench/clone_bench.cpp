// A plan of a 64x64 sheet for one more state: compiled again, cloned, or with a workspace only. `bytes` is the memory of each.
#include <benchmark/benchmark.h>

#include <string>

#include "dvdx/layouts/state_hash.hpp"
#include "dvdx/plan.hpp"
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/starts.hpp"

namespace dvdx::bench {
namespace {

// Returns true if a clone steps a state as its plan does.
bool is_right(const Plan<float>& plan) {
  Held<float> by_plan = hung();
  Held<float> by_clone = hung();
  (void)plan.step(by_plan.state, 3);
  (void)plan.clone().step(by_clone.state, 3);
  return state_hash(by_plan.state) == state_hash(by_clone.state);
}

void time_compile(benchmark::State& timing, Scheme scheme) {
  const Held<float> held = hung();
  const Scene scene = hung_sheet(scheme);
  for (auto _ : timing) benchmark::DoNotOptimize(compile<float>(scene, {}, held.state));
}

void time_clone(benchmark::State& timing, Scheme scheme) {
  const Held<float> held = hung();
  const auto plan = compile<float>(hung_sheet(scheme), {}, held.state);
  for (auto _ : timing) benchmark::DoNotOptimize(plan->clone());
  timing.counters["bytes"] = static_cast<double>(plan->workspace().bytes());
  if (!is_right(*plan)) timing.SkipWithError("a clone gives other bits");
}

}  // namespace

void register_clone(Pace pace) {
  for (const auto& [name, scheme] : {std::pair{"leapfrog", Scheme::leapfrog}, std::pair{"sequential", Scheme::sequential}}) {
    add(pace, std::string("clone/compile/") + name,
        [scheme = scheme](benchmark::State& timing) { time_compile(timing, scheme); });
    add(pace, std::string("clone/clone/") + name, [scheme = scheme](benchmark::State& timing) { time_clone(timing, scheme); });
  }
}

}  // namespace dvdx::bench
