// The cost of a call: step() of few particles, seek and set_step. For steps of many particles see block_loop_bench.cpp.
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"

namespace dvdx::bench {
namespace {

template <class T>
void add_small(Pace pace) {
  const Case<T> work{.name = "step/small", .scene = [](std::size_t) { return meadow(); }, .steps = 1};
  for (const std::size_t count : {1U, 16U, 64U, 256U}) {
    add_plan(pace, work, {best_isa(), Arithmetic::separate}, {"count:" + std::to_string(count), count});
  }
}

template <class T>
void time_seek(benchmark::State& timing) {
  Held<T> held = hold_padded<T>(in_first_cache<T>()), start = hold_padded<T>(in_first_cache<T>());
  scatter_about(held.state);
  scatter_about(start.state);
  const auto plan = compile<T>(meadow(), {}), reference = compile<T>(meadow(), {.isa = Isa::reference});
  for (auto _ : timing) benchmark::DoNotOptimize(plan->seek(held.state, 216000));
  timing.SetItemsProcessed(timing.iterations() * static_cast<std::int64_t>(held.state.count));
  scatter_about(held.state);
  const bool is_sought = plan->seek(held.state, 1000) && reference->seek(start.state, 1000);
  if (!is_sought || !is_same_bits(held.state, start.state, start.state.count))
    timing.SkipWithError("differs from the reference");
}

void time_set_step(benchmark::State& timing, Scene (*scene)()) {
  auto plan = compile<float>(scene(), {});
  for (auto _ : timing) benchmark::DoNotOptimize(plan->set_step(frame));
  timing.SetItemsProcessed(timing.iterations());
}

}  // namespace

void register_step(Pace pace) {
  add_small<float>(pace);
  add_small<double>(pace);
  add(pace, "step/seek/float32/L1", time_seek<float>);
  add(pace, "step/seek/float64/L1", time_seek<double>);
  add(pace, "step/set_step/fused/float32", [](benchmark::State& timing) { time_set_step(timing, meadow); });
  add(pace, "step/set_step/shear/float32", [](benchmark::State& timing) { time_set_step(timing, swing); });
}

}  // namespace dvdx::bench
