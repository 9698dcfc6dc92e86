// A bar's plans, particles and work, and the bars by subject.
#pragma once

#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>

#include "dvdx/plan.hpp"
#include "support/held.hpp"
#include "support/plain.hpp"
#include "support/race.hpp"
#include "support/report.hpp"
#include "support/threads.hpp"

namespace dvdx::bench {

inline constexpr std::size_t in_cache = 1024, in_second_cache = 16384, in_memory = 8'000'000;

struct Run {
  Effort effort;         // in cache
  Effort memory_effort;  // one call is a sample
  [[nodiscard]] Effort in_memory_on(int threads) const {
    Effort of_threads = memory_effort;
    of_threads.timer = threads > 1 ? Timer::wall : Timer::thread;
    return of_threads;
  }
};

template <class T>
Plan<T> make_plan(const Scene& scene, const Options& options = {}) {
  auto plan = compile<T>(scene, options);
  if (!plan) {
    std::fprintf(stderr, "%s\n", plan.error().message().c_str());
    std::exit(1);
  }
  return std::move(*plan);
}

// A plan, its particles, and the way it is called.
template <class T>
struct Stepper {
  std::shared_ptr<Plan<T>> plan;
  Held<T> held;
  std::size_t steps = 1;
  ParallelFor parallel{};
  void operator()() { (void)plan->step(held.state, steps, parallel); }
};

template <class T>
Held<T> scattered(std::size_t count, Hold<T> hold = hold_padded<T>) {
  Held<T> held = hold(count);
  scatter_about(held.state);
  return held;
}

template <class T>
Stepper<T> stepper(const Scene& scene, const Held<T>& held, std::size_t steps, int threads = 1, const Options& options = {}) {
  return {std::make_shared<Plan<T>>(make_plan<T>(scene, options)), held, steps, on_threads(threads)};
}

// Scales the six columns, one slice for each thread. The factor is 1, which keeps the values; the compiler does not know it.
struct Scaling {
  PlainArrays<float> arrays;
  int threads = 1;

  void operator()() {
    if (threads == 1) return scale_in_place(arrays, 1.0F, 0, arrays.count);
    const ParallelFor parallel = on_threads(threads);
    parallel.run(parallel.context, static_cast<std::size_t>(threads), slice, this);
  }
  static void slice(void* task, std::size_t index) {
    const auto& scaling = *static_cast<const Scaling*>(task);
    const std::size_t n = scaling.arrays.count, threads = static_cast<std::size_t>(scaling.threads);
    scale_in_place(scaling.arrays, 1.0F, n * index / threads, n * (index + 1) / threads);
  }
};

inline std::string per_step(double seconds, std::size_t particle_steps) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.3f ns", seconds * 1e9 / static_cast<double>(particle_steps));
  return text.data();
}

inline std::string against(const Race& race, std::size_t steps_a, std::size_t steps_b) {
  return per_step(race.a, steps_a) + " against " + per_step(race.b, steps_b) + " a particle and step";
}

// The ratio a/b in particle-steps per second or the like, if b did `more` times the work of a.
inline Race times(Race race, double more) {
  race.median *= more;
  race.lowest *= more;
  race.highest *= more;
  return race;
}

inline std::string threads_of(int threads) { return threads == 1 ? ", 1 thread" : ", 2 threads"; }

// Steps the particles held by a scene whose networks join them.
Stepper<float> joined_stepper(Scene scene, const Held<float>& held);

// Bars of one subject each. Bars in memory take their particles from the caller.
void affine_in_memory(Report& report, const Run& run, const Held<float>& held);
void affine_in_cache(Report& report, const Run& run);
void steps_per_call(Report& report, const Run& run, const Held<float>& held);
void against_plain_loops(Report& report, const Run& run, const Held<float>& held);
void two_threads(Report& report, const Run& run, const Held<float>& held);
void decay(Report& report, const Run& run);
void contact(Report& report, const Run& run, const Held<float>& held);
void hits(Report& report, const Run& run);
void rates(Report& report, const Run& run);
void work_precision(Report& report, const Run& run);
void overheads(Report& report, const Run& run, const Held<float>& held);
void layouts(Report& report, const Run& run);
void layouts_beside_columns(Report& report, const Run& run);
void structs(Report& report, const Run& run);
void turnover(Report& report, const Run& run);
void c_api(Report& report, const Run& run);
void hundred_sheets(Report& report, const Run& run);
void moving_world(Report& report, const Run& run);

}  // namespace dvdx::bench
