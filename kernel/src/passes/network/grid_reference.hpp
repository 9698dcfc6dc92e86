// The pulse of a grid's springs, scalar: each particle sums the springs to its neighbours, in the order of their numbers.
#pragma once

#include "passes/network/pull_reference.hpp"

namespace dvdx::reference {

template <Arithmetic arithmetic, class T>
Vector<T> pull_between(const GridTerms<T>& grid, const WorkColumns<T>& work, const Family<T>& family, std::size_t a,
                       std::size_t b) noexcept {
  const Vector<T> d = minus(at(work.x, b), at(work.x, a));
  if (grid.damping == Damping::none) return pull<arithmetic>(d, family.k, family.kl);
  return damped_pull<arithmetic>(d, minus(at(work.v, b), at(work.v, a)), family.k, family.kl, family.c);
}

// One direction of a grid's springs, from (row, column) to (row + down, column + right).
template <class T>
struct Lead {
  std::ptrdiff_t down, right;
  const Family<T>* family;
};

// In the order of the neighbour's number.
template <class T>
std::array<Lead<T>, 6> leads(const GridFamilies<T>& f) noexcept {
  return {{{0, 1, &f.right},
           {0, 2, &f.right2},
           {1, -1, &f.left_below},
           {1, 0, &f.below},
           {1, 1, &f.right_below},
           {2, 0, &f.below2}}};
}

enum class End { near, far };  // which end of the spring the particle is

template <Arithmetic arithmetic, class T>
void add_neighbour(const GridTerms<T>& grid, const WorkColumns<T>& work, const Lead<T>& lead, End end, std::size_t row,
                   std::size_t column, Vector<T>& F) noexcept {
  if (!lead.family->is_there()) return;
  const std::ptrdiff_t sign = end == End::near ? 1 : -1;
  const std::ptrdiff_t other_row = static_cast<std::ptrdiff_t>(row) + sign * lead.down;
  const std::ptrdiff_t other_column = static_cast<std::ptrdiff_t>(column) + sign * lead.right;
  const bool is_there = other_row >= 0 && other_row < static_cast<std::ptrdiff_t>(grid.rows) && other_column >= 0 &&
                        other_column < static_cast<std::ptrdiff_t>(grid.columns);
  if (!is_there) return;
  const std::size_t own = row * grid.pitch + column;
  const std::size_t other = static_cast<std::size_t>(other_row) * grid.pitch + static_cast<std::size_t>(other_column);
  F = plus(F, pull_between<arithmetic>(grid, work, *lead.family, own, other));
}

template <class T, Arithmetic arithmetic>
void kick_grid(const GridTerms<T>& grid, const WorkColumns<T>& work, T pulse, std::size_t from, std::size_t to) noexcept {
  const auto directions = leads(grid.along);
  for (std::size_t row = from; row < to; ++row) {
    for (std::size_t column = 0; column < grid.columns; ++column) {
      Vector<T> F{};
      for (std::size_t f = directions.size(); f-- > 0;) {
        add_neighbour<arithmetic>(grid, work, directions[f], End::far, row, column, F);
      }
      for (const Lead<T>& lead : directions) add_neighbour<arithmetic>(grid, work, lead, End::near, row, column, F);
      const std::size_t i = row * grid.pitch + column;
      const T w = pulse * work.w[i];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        work.v_next[axis][i] = multiply_add<arithmetic>(w, F[axis], work.v[axis][i]);
      }
    }
  }
}

}  // namespace dvdx::reference
