// The pulse of a grid's springs, scalar: each particle sums the springs to its neighbours, in the order of their numbers.
#pragma once

#include "passes/network/pull_reference.hpp"

namespace dvdx::reference {

template <Arithmetic arithmetic, class T>
Vector<T> pull_between(const GridTerms<T>& grid, const Sheet<T>& sheet, const Family<T>& family, std::size_t a,
                       std::size_t b) noexcept {
  const Vector<T> d = minus(at(sheet.x, b), at(sheet.x, a));
  if (grid.damping == Damping::none) return pull<arithmetic>(d, family.k, family.kl);
  return damped_pull<arithmetic>(d, minus(at(sheet.v, b), at(sheet.v, a)), family.k, family.kl, grid.c);
}

enum class End { near, far };  // which end of a family's spring the particle is

template <Arithmetic arithmetic, class T>
void add_neighbour(const GridTerms<T>& grid, const Sheet<T>& sheet, const Family<T>& family, End end, std::size_t row,
                   std::size_t column, Vector<T>& F) noexcept {
  const auto down = static_cast<std::ptrdiff_t>(family.down);
  const std::ptrdiff_t sign = end == End::near ? 1 : -1;
  const std::ptrdiff_t other_row = static_cast<std::ptrdiff_t>(row) + sign * down;
  const std::ptrdiff_t other_column = static_cast<std::ptrdiff_t>(column) + sign * family.right;
  const bool is_there = other_row >= 0 && other_row < static_cast<std::ptrdiff_t>(grid.rows) && other_column >= 0 &&
                        other_column < static_cast<std::ptrdiff_t>(grid.columns);
  if (!is_there) return;
  const std::size_t own = row * grid.pitch + column;
  const std::size_t other = static_cast<std::size_t>(other_row) * grid.pitch + static_cast<std::size_t>(other_column);
  F = plus(F, pull_between<arithmetic>(grid, sheet, family, own, other));
}

template <class T, Arithmetic arithmetic>
void kick_grid(const GridTerms<T>& grid, const Sheet<T>& sheet, T pulse, std::size_t from, std::size_t to) noexcept {
  for (std::size_t row = from; row < to; ++row) {
    for (std::size_t column = 0; column < grid.columns; ++column) {
      Vector<T> F{};
      for (std::size_t f = grid.family_count; f-- > 0;) {
        add_neighbour<arithmetic>(grid, sheet, grid.families[f], End::far, row, column, F);
      }
      for (std::size_t f = 0; f < grid.family_count; ++f) {
        add_neighbour<arithmetic>(grid, sheet, grid.families[f], End::near, row, column, F);
      }
      const std::size_t i = row * grid.pitch + column;
      const T w = pulse * sheet.w[i];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        sheet.v_next[axis][i] = multiply_add<arithmetic>(w, F[axis], sheet.v[axis][i]);
      }
    }
  }
}

}  // namespace dvdx::reference
