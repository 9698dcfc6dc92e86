// A scene run on the library from its start, for the report.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <exception>
#include <stdexcept>
#include <utility>

#include "dvdx/plan.hpp"
#include "scene_io/plan_fault.hpp"
#include "state/engine.hpp"
#include "state/start.hpp"
#include "state/state_memory.hpp"

namespace dvdx::tool::report {

using WallClock = std::chrono::steady_clock;
inline constexpr WallClock::time_point never = WallClock::time_point::max();

// The way in which the library runs.
struct Setup {
  Engine engine;
  ParallelFor parallel{};
  WallClock::time_point end = never;  // a run that lasts longer is given up
};

// Thrown when a run is given up.
class OutOfTime final : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return "a run was given up: the time for it was over"; }
};

// Calls `use` with a zero of the scalar type of this precision's states.
template <class Use>
decltype(auto) with_scalar(Precision precision, const Use& use) {
  if (is_kept_in_float64(precision)) return use(double{});
  return use(float{});
}

template <class T>
[[nodiscard]] Plan<T> compiled(const SceneFile& file, const Scene& scene, double step, const Engine& engine,
                               const State<T>& start) {
  const Options options{
      .step = step, .isa = engine.isa, .arithmetic = engine.arithmetic, .rounding = rounding_of(engine.precision)};
  auto plan = compile<T>(scene, options, start);
  if (!plan) throw fault_of(file, plan.error());
  return std::move(*plan);
}

// Both states must have the same layout and count.
template <class T>
void copy_state(const State<T>& from, State<T>& to) {
  const auto copy_column = [&](const Column<T>& source, const Column<T>& target) {
    if (source.is_contiguous() && target.is_contiguous()) {
      std::copy_n(source.base, from.count, target.base);
      return;
    }
    for (std::size_t i = 0; i < from.count; ++i) target[i] = source[i];
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    copy_column(from.x[axis], to.x[axis]);
    copy_column(from.v[axis], to.v[axis]);
    if (!from.has_rests()) continue;
    copy_column(from.x_rest[axis], to.x_rest[axis]);
    copy_column(from.v_rest[axis], to.v_rest[axis]);
  }
  to.clock = from.clock;
}

template <class T>
void advance(const Plan<T>& plan, State<T>& state, std::uint64_t steps, const ParallelFor& parallel) {
  if (plan.step(state, steps, parallel) != StepResult::done) throw std::logic_error("the plan is for another state");
}

// The same. If there is an end, each call takes a limited number of steps.
template <class T>
void advance(const Plan<T>& plan, State<T>& state, std::uint64_t steps, const Setup& setup) {
  if (setup.end == never) return advance(plan, state, steps, setup.parallel);
  constexpr std::chrono::milliseconds often{20};
  for (std::uint64_t some = 1; steps > 0;) {
    const auto before = WallClock::now();
    if (before > setup.end) throw OutOfTime();
    const auto now = std::min(some, steps);
    advance(plan, state, now, setup.parallel);
    steps -= now;
    if (WallClock::now() - before < often) some *= 2;
  }
}

// The number of steps in one call, as in `dvdx run`: large, so that a block stays in cache for them.
[[nodiscard]] inline std::uint64_t steps_per_call(std::size_t particles) {
  constexpr std::uint64_t particle_steps = std::uint64_t{1} << 24U;
  const auto steps = particle_steps / particles;
  return steps < 8 ? 8 : steps > 4096 ? 4096 : steps;
}

}  // namespace dvdx::tool::report
