// Whether a state is one that a plan may step.
#pragma once

#include "dvdx/layouts/state.hpp"
#include "dvdx/plan.hpp"
#include "plan/compiled_scene.hpp"
#include "scene/state_columns.hpp"

namespace dvdx {

// Whether the scene takes a state of `particles` particles.
template <class A>
bool takes(const CompiledScene<A>& scene, std::size_t particles) noexcept {
  if (!scene.count) return true;
  return scene.particles == Particles::come_and_meet ? particles <= *scene.count : particles == *scene.count;
}

// Checks the count and the columns. A: the scalar of the computation.
template <class A, class T>
StepResult fit_of_columns(const CompiledScene<A>& scene, const State<T>& state) noexcept {
  if (!takes(scene, state.count)) return StepResult::count_differs;
  return are_columns_short<A>(state) ? StepResult::capacity_too_small : StepResult::done;
}

template <class A, class T>
StepResult fit_of(const CompiledScene<A>& scene, const State<T>& state) noexcept {
  const StepResult columns = fit_of_columns(scene, state);
  if (columns != StepResult::done) return columns;
  return state.clock.is_finite() ? StepResult::done : StepResult::time_not_finite;
}

}  // namespace dvdx
