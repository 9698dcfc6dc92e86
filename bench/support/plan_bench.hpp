// Registers benchmarks of a plan: every worthwhile ISA, arithmetic, precision, size and thread count.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/plan.hpp"
#include "support/held.hpp"
#include "support/pace.hpp"
#include "support/threads.hpp"

namespace dvdx::bench {

struct Size {
  std::string name;
  std::size_t count;
};

template <class T>
constexpr std::size_t in_first_cache() {
  return 4096 / sizeof(T);  // particles: 24 KiB
}
inline Size in_second_cache(Pace pace) { return {"L2", pace == Pace::timed ? 16384U : 5000U}; }
inline Size in_memory(Pace pace) { return pace == Pace::timed ? Size{"memory", 8'000'000} : Size{"many", 100'000}; }

template <class T>
std::string scalar_name() {
  return sizeof(T) == sizeof(float) ? "float32" : "float64";
}

// A timed case. The scene is made for a count, and its first particles do not depend on the count.
template <class T>
struct Case {
  std::string name;
  std::function<Scene(std::size_t count)> scene;
  void (*start)(State<T>&) = scatter_about<T>;
  Hold<T> hold = hold_padded<T>;
  std::size_t steps = 1;  // a call
};

struct How {
  Isa isa;
  Arithmetic arithmetic;
  int threads = 1;
};

template <class T>
Expected<Plan<T>> plan_of(const Case<T>& work, const How& how, const State<T>& state) {
  return compile<T>(work.scene(state.count), {.isa = how.isa, .arithmetic = how.arithmetic}, state);
}

// Returns true if one call from the start gives the reference's bits. A large batch is compared in its first few thousand
// particles.
template <class T>
bool is_right(const Case<T>& work, const How& how, State<T>& state) {
  Held<T> expected = hold_padded<T>(std::min<std::size_t>(state.count, 4097));
  work.start(expected.state);
  const auto reference = plan_of<T>(work, {Isa::reference, how.arithmetic}, expected.state);
  work.start(state);
  const auto plan = plan_of<T>(work, how, state);
  if (!reference || !plan) return false;
  (void)reference->step(expected.state, work.steps);
  (void)plan->step(state, work.steps, on_threads(how.threads));
  return is_same_bits(state, expected.state, expected.state.count);
}

// Sets the counters of a loop over `count` particles, `steps` times an iteration.
template <class T>
void count_work(benchmark::State& timing, std::size_t count, std::size_t steps) {
  const auto done = static_cast<double>(timing.iterations()) * static_cast<double>(count * steps);
  timing.SetItemsProcessed(static_cast<std::int64_t>(done));
  timing.SetBytesProcessed(static_cast<std::int64_t>(done * 12 * sizeof(T)));  // six columns, read and written
}

template <class T>
void time_plan(benchmark::State& timing, const Case<T>& work, const How& how, std::size_t count) {
  Held<T> held = work.hold(count);
  work.start(held.state);
  const auto plan = plan_of<T>(work, how, held.state);
  if (!plan) return timing.SkipWithError(plan.error().message().c_str());
  const ParallelFor parallel = on_threads(how.threads);
  for (auto _ : timing) (void)plan->step(held.state, work.steps, parallel);
  count_work<T>(timing, count, work.steps);
  if (!is_right(work, how, held.state)) timing.SkipWithError("differs from the reference");
}

// One thread is timed by the processor's time, which other programs disturb least; two threads by wall time.
template <class Function>
void add(Pace pace, const std::string& name, Function function, int threads = 1) {
  auto* const added = benchmark::RegisterBenchmark(name.c_str(), std::move(function));
  if (pace == Pace::timed) {
    added->MinTime(0.02);
  } else {
    added->Iterations(1);
  }
  if (threads > 1) added->UseRealTime();
}

template <class T>
void add_plan(Pace pace, const Case<T>& work, const How& how, const Size& size) {
  const std::string name = work.name + "/" + scalar_name<T>() + "/" + std::string(dvdx::name(how.isa)) + "/" +
                           std::string(dvdx::name(how.arithmetic)) + "/" + size.name +
                           "/threads:" + std::to_string(how.threads);
  add(
      pace, name, [work, how, count = size.count](benchmark::State& timing) { time_plan(timing, work, how, count); },
      how.threads);
}

// All ISAs, with the particles in cache.
template <class T>
void add_in_cache(Pace pace, const Case<T>& work) {
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted}) {
    for (const Isa isa : available_isas(arithmetic)) {
      for (const Size& size : {Size{"L1", in_first_cache<T>()}, in_second_cache(pace)})
        add_plan(pace, work, {isa, arithmetic}, size);
    }
  }
}

// The best ISA and the reference, with the particles in memory, on one thread and on two.
template <class T>
void add_in_memory(Pace pace, const Case<T>& work) {
  add_plan(pace, work, {Isa::reference, Arithmetic::separate}, in_memory(pace));
  for (int threads = 1; threads <= most_threads(); ++threads) {
    add_plan(pace, work, {best_isa(), Arithmetic::separate, threads}, in_memory(pace));
  }
}

template <class T>
void add_everywhere(Pace pace, const Case<T>& work) {
  add_in_cache(pace, work);
  add_in_memory(pace, work);
}

// A plain loop over six arrays: step(arrays) for each iteration. The result is only checked to be finite, because the method
// differs.
template <class T, class Step>
void time_plain(benchmark::State& timing, std::size_t count, void (*start)(State<T>&), const Step& step) {
  Held<T> held = hold_padded<T>(count);
  start(held.state);
  const PlainArrays<T> arrays = arrays_of(held.state);
  for (auto _ : timing) {
    step(arrays);
    benchmark::ClobberMemory();
  }
  count_work<T>(timing, count, 1);
  if (!std::isfinite(arrays.x[0][count / 2]) || !std::isfinite(arrays.v[1][count - 1])) timing.SkipWithError("not finite");
}

template <class T, class Step>
void add_plain(Pace pace, const std::string& name, Step step, void (*start)(State<T>&) = scatter_about<T>) {
  for (const Size& size : {Size{"L1", in_first_cache<T>()}, in_second_cache(pace), in_memory(pace)}) {
    add(pace, name + "/" + scalar_name<T>() + "/plain/" + size.name + "/threads:1",
        [count = size.count, step, start](benchmark::State& timing) { time_plain<T>(timing, count, start, step); });
  }
}

}  // namespace dvdx::bench
