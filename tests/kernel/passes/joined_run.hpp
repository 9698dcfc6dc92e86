// Stepping of joined particles in tests of networks and constraints.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"
#include "support/batch.hpp"
#include "support/threads.hpp"

namespace dvdx::test {

struct Run {
  Isa isa = Isa::reference;
  Arithmetic arithmetic = Arithmetic::separate;
  Layout layout = Layout::soa;
  std::size_t threads = 1;
};

template <class T>
Plan<T> plan_of(const Joined& joined, const Run& run, const State<T>& start) {
  auto plan = compile<T>(joined.scene, {.step = joined.step, .isa = run.isa, .arithmetic = run.arithmetic}, start);
  REQUIRE_MESSAGE(plan.has_value(), joined.name << ": " << plan.error().message());
  return std::move(*plan);
}

// The same, for the start of the scene.
template <class T>
Plan<T> plan_of(const Joined& joined, const Run& run) {
  Batch<T> start(run.layout, joined.x.size());
  place(joined, start.view());
  return plan_of(joined, run, start.view());
}

// The values of all particles after `steps` steps by a clone of the plan, which itself stays unchanged.
template <class T>
std::vector<T> stepped(const Joined& joined, const Plan<T>& plan, const Run& run, std::size_t steps) {
  Batch<T> batch(run.layout, joined.x.size());
  place(joined, batch.view());
  Threads workers(run.threads);
  const ParallelFor parallel = run.threads > 1 ? workers.parallel_for() : ParallelFor{};
  REQUIRE(plan.clone().step(batch.view(), steps, parallel) == StepResult::done);
  CHECK(batch.is_clean());
  return values_of(batch.view());
}
template <class T>
std::vector<T> stepped(const Joined& joined, const Run& run, std::size_t steps) {
  return stepped(joined, plan_of<T>(joined, run), run, steps);
}

// The largest difference of any two values.
inline double apart(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

}  // namespace dvdx::test
