// The cutting of work into tasks, and the one loop that hands them to the caller's threads.
#pragma once

#include <cstddef>

#include "dvdx/parallel.hpp"
#include "work/environment.hpp"

namespace dvdx {

// Below this many particle-steps, waking a thread costs more than it saves.
inline constexpr std::size_t steps_worth_threads = std::size_t{1} << 16;

constexpr std::size_t tasks_of(std::size_t count, std::size_t per_task) noexcept { return (count + per_task - 1) / per_task; }

// Runs body(task) for every task below count on the caller's threads, each in the floating-point environment of a step. The
// calling thread is in it already. The cut into tasks never depends on the threads that take them, and so no result does.
template <class Body>
void for_each_task(const ParallelFor& parallel, std::size_t count, const Body& body) noexcept {
  if (parallel.run == nullptr || count < 2) {
    for (std::size_t task = 0; task < count; ++task) body(task);
    return;
  }
  const auto run = [](void* context, std::size_t task) noexcept {
    const StepEnvironment environment;
    (*static_cast<const Body*>(context))(task);
  };
  parallel.run(parallel.context, count, run, const_cast<Body*>(&body));  // the callback's signature; nothing writes to it
}

}  // namespace dvdx
