// Whether a state is one that a plan may step.
#pragma once

#include <algorithm>
#include <array>
#include <type_traits>

#include "compile/compiled_scene.hpp"
#include "dvdx/layouts/state.hpp"
#include "dvdx/plan.hpp"

namespace dvdx {

// Its count and its columns. A: what the scene is worked out in.
template <class A, class T>
StepResult fit_of_columns(const CompiledScene<A>& scene, const State<T>& state) noexcept {
  if (scene.count && *scene.count != state.count) return StepResult::count_differs;
  const auto is_small = [&](const std::array<Column<T>, 3>& columns) {
    return std::any_of(columns.begin(), columns.end(),
                       [&](const Column<T>& c) { return c.capacity < state.count || (c.base == nullptr && state.count != 0); });
  };
  const bool needs_rests = !std::is_same_v<A, T>;
  const bool is_any_small =
      is_small(state.x) || is_small(state.v) || (needs_rests && (is_small(state.x_rest) || is_small(state.v_rest)));
  return is_any_small ? StepResult::capacity_too_small : StepResult::done;
}

template <class A, class T>
StepResult fit_of(const CompiledScene<A>& scene, const State<T>& state) noexcept {
  const StepResult columns = fit_of_columns(scene, state);
  if (columns != StepResult::done) return columns;
  return state.clock.is_finite() ? StepResult::done : StepResult::time_not_finite;
}

}  // namespace dvdx
