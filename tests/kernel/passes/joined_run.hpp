// How the tests of networks and constraints step what is joined.
#pragma once

#include <doctest/doctest.h>

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

// The values of all particles after so many steps.
template <class T>
std::vector<T> stepped(const Joined& joined, const Run& run, std::size_t steps) {
  Batch<T> batch(run.layout, joined.x.size());
  place(joined, batch.view());
  const Plan<T> plan = plan_of(joined, run, batch.view());
  Threads workers(run.threads);
  const ParallelFor parallel = run.threads > 1 ? workers.parallel_for() : ParallelFor{};
  REQUIRE(plan.step(batch.view(), steps, parallel) == StepResult::done);
  CHECK(batch.is_clean());
  return values_of(batch.view());
}

}  // namespace dvdx::test
