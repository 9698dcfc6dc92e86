// Checks whether a state's columns have memory for all of its particles.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>

#include "dvdx/layouts/state.hpp"
#include "dvdx/plan.hpp"

namespace dvdx {

template <class T>
bool are_short(const std::array<Column<T>, 3>& columns, std::size_t count) noexcept {
  return std::any_of(columns.begin(), columns.end(), [count](const Column<T>& column) {
    return column.capacity < count || (column.base == nullptr && count != 0);
  });
}

// Returns true if any column that a step reads is too short. A: the type in which the scene is computed.
template <class A, class T>
bool are_columns_short(const State<T>& state) noexcept {
  const bool needs_rests = !std::is_same_v<A, T>;
  return are_short(state.x, state.count) || are_short(state.v, state.count) ||
         (needs_rests && (are_short(state.x_rest, state.count) || are_short(state.v_rest, state.count)));
}

[[nodiscard]] inline Error short_columns(const char* state) {
  return {state, "columns without memory, or too short", "columns for all of its particles"};
}

}  // namespace dvdx
