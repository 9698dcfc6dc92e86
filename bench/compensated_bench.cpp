// The cost of compensated float32 compared with float32, float64, and Kahan's sum in float32 lanes.
#include "dvdx/layouts/convert.hpp"
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"

namespace dvdx::bench {
namespace {

void time_compensated(benchmark::State& timing, std::size_t count, std::size_t steps) {
  Held<float> held = hold_padded<float>(count), rests = hold_padded<float>(count);
  Held<double> wide = hold_padded<double>(count);
  scatter_about(held.state);
  copy(held.state, wide.state);
  State<float> state = compensated(held.state, rests.state);
  const auto plan = compile<float>(meadow(), {.rounding = Rounding::compensated}, state);
  const auto reference = compile<double>(meadow(), {.isa = Isa::reference}, wide.state);
  if (!plan || !reference) return timing.SkipWithError("no plan");
  (void)plan->step(state, steps);
  (void)reference->step(wide.state, steps);
  for (std::size_t i = 0; i < count; ++i) {
    if (state.x[0][i] != static_cast<float>(wide.state.x[0][i])) timing.SkipWithError("differs from the float64 step");
  }
  for (auto _ : timing) (void)plan->step(state, steps);
  count_work<double>(timing, count, steps);
}

void time_kahan(benchmark::State& timing, std::size_t count) {
  Held<float> held = hold_padded<float>(count), rests = hold_padded<float>(count);
  scatter_about(held.state);
  const PlainArrays<float> arrays = arrays_of(held.state);
  for (auto _ : timing) {
    plain_kahan_step(arrays, arrays_of(rests.state), 0.6F, 0.006F, 0.005F, 0.0166F);
    benchmark::ClobberMemory();
  }
  count_work<double>(timing, count, 1);
  if (!std::isfinite(arrays.x[0][count / 2])) timing.SkipWithError("not finite");
}

}  // namespace

void register_compensated(Pace pace) {
  for (const Size& size : {Size{"L1", in_first_cache<double>()}, in_second_cache(pace), in_memory(pace)}) {
    add(pace, "compensated/plain_kahan/steps:1/" + size.name,
        [=](benchmark::State& timing) { time_kahan(timing, size.count); });
  }
  for (const std::size_t steps : {1U, 8U}) {
    for (const Size& size : {Size{"L1", in_first_cache<double>()}, in_second_cache(pace), in_memory(pace)}) {
      const std::string ends = "/steps:" + std::to_string(steps) + "/" + size.name;
      add(pace, "compensated/float32_compensated" + ends,
          [=](benchmark::State& timing) { time_compensated(timing, size.count, steps); });
      const auto plain = [&]<class T>(const char* name) {
        const Case<T> work{.name = name, .scene = [](std::size_t) { return meadow(); }, .steps = steps};
        add(pace, "compensated/" + std::string(name) + ends, [work, size](benchmark::State& timing) {
          time_plan(timing, work, {best_isa(), Arithmetic::separate}, size.count);
        });
      };
      plain.operator()<float>("float32");
      plain.operator()<double>("float64");
    }
  }
}

}  // namespace dvdx::bench
