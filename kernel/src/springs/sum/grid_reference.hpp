// The pulse of a grid's springs, scalar: each particle sums the springs to its neighbours, in the order of their numbers.
#pragma once

#include <algorithm>

#include "springs/pull_reference.hpp"

namespace dvdx::reference {

// One direction of a grid's springs, from (row, column) to (row + down, column + right).
template <class T>
struct Lead {
  std::ptrdiff_t down, right;
  const Family<T>* family;
  std::size_t line;  // the index of the direction's line in a row of GridTerms::whole
};

// In the order of the neighbour's number.
template <class T>
std::array<Lead<T>, 6> leads(const GridFamilies<T>& f) noexcept {
  return {{{0, 1, &f.right, 0},
           {0, 2, &f.right2, 1},
           {1, -1, &f.left_below, 2},
           {1, 0, &f.below, 3},
           {1, 1, &f.right_below, 4},
           {2, 0, &f.below2, 5}}};
}

enum class End { near, far };  // which end of the spring the particle is

// pull(family, own, other) is one spring.
template <class T, class Pull>
void add_neighbour(const GridTerms<T>& grid, const Lead<T>& lead, End end, std::size_t row, std::size_t column,
                   const Pull& pull, Vector<T>& F) noexcept {
  if (!lead.family->is_there()) return;
  const std::ptrdiff_t sign = end == End::near ? 1 : -1;
  const std::ptrdiff_t other_row = static_cast<std::ptrdiff_t>(row) + sign * lead.down;
  const std::ptrdiff_t other_column = static_cast<std::ptrdiff_t>(column) + sign * lead.right;
  const bool is_there = other_row >= 0 && other_row < static_cast<std::ptrdiff_t>(grid.rows) && other_column >= 0 &&
                        other_column < static_cast<std::ptrdiff_t>(grid.columns);
  if (!is_there) return;
  const T* const whole = grid.whole_from(std::min(row, static_cast<std::size_t>(other_row)));
  const std::size_t lesser = std::min(column, static_cast<std::size_t>(other_column));
  if (whole != nullptr && whole[lead.line * grid.pitch + lesser] != T(1)) return;
  const std::size_t own = row * grid.pitch + column;
  const std::size_t other = static_cast<std::size_t>(other_row) * grid.pitch + static_cast<std::size_t>(other_column);
  F = plus(F, pull(*lead.family, own, other));
}

// leave(particle, F) takes the sum of each.
template <class T, class Pull, class Leave>
void for_each_of_grid(const GridTerms<T>& grid, std::size_t from, std::size_t to, const Pull& pull,
                      const Leave& leave) noexcept {
  const auto directions = leads(grid.along);
  for (std::size_t row = from; row < to; ++row) {
    for (std::size_t column = 0; column < grid.columns; ++column) {
      Vector<T> F{};
      for (std::size_t f = directions.size(); f-- > 0;) add_neighbour(grid, directions[f], End::far, row, column, pull, F);
      for (const Lead<T>& lead : directions) add_neighbour(grid, lead, End::near, row, column, pull, F);
      leave(row * grid.pitch + column, F);
    }
  }
}

template <class T, Arithmetic arithmetic>
void kick_grid(const GridTerms<T>& grid, const WorkColumns<T>& work, T pulse, std::size_t from, std::size_t to) noexcept {
  const auto pull_between = [&](const Family<T>& family, std::size_t a, std::size_t b) {
    return pull<arithmetic>(minus(at(work.x, b), at(work.x, a)), family.k, family.kl);
  };
  for_each_of_grid(grid, from, to, pull_between, [&](std::size_t i, const Vector<T>& F) {
    const T w = pulse * work.w[i];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      work.v_next[axis][i] = multiply_add<arithmetic>(w, F[axis], work.v[axis][i]);
    }
  });
}

template <class T, Arithmetic arithmetic>
void accelerate_grid(const GridTerms<T>& grid, const WorkColumns<T>& work, std::size_t from, std::size_t to) noexcept {
  const auto pull_between = [&](const Family<T>& family, std::size_t a, std::size_t b) {
    const Vector<T> u = minus(at(work.v, b), at(work.v, a));
    return damped_pull<arithmetic>(minus(at(work.x, b), at(work.x, a)), u, family.k, family.kl, family.c);
  };
  for_each_of_grid(grid, from, to, pull_between, [&](std::size_t i, const Vector<T>& F) { leave_acceleration(work, i, F); });
}

template <class T, Arithmetic arithmetic>
void damp_grid(const GridTerms<T>& grid, const WorkColumns<T>& work, const DampingPass<T>& pass, std::size_t from,
               std::size_t to) noexcept {
  const auto pull_between = [&](const Family<T>& family, std::size_t a, std::size_t b) {
    const Vector<T> u = minus(at(pass.of, b), at(pass.of, a));
    return damping_pull<arithmetic>(minus(at(work.x, b), at(work.x, a)), u, family.c);
  };
  for_each_of_grid(grid, from, to, pull_between,
                   [&](std::size_t i, const Vector<T>& F) { leave_damped<arithmetic>(work, pass, i, F); });
}

}  // namespace dvdx::reference
