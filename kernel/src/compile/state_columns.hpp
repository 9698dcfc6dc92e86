// Whether a state's columns have memory, for all that reads one beside a step.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include "dvdx/layouts/state.hpp"
#include "dvdx/plan.hpp"

namespace dvdx {

template <class T>
bool are_short(const std::array<Column<T>, 3>& columns, std::size_t count) noexcept {
  return std::any_of(columns.begin(), columns.end(), [count](const Column<T>& column) {
    return column.capacity < count || (column.base == nullptr && count != 0);
  });
}

[[nodiscard]] inline Error short_columns(const char* state) {
  return {state, "columns without memory, or too short", "columns for all of its particles"};
}

}  // namespace dvdx
