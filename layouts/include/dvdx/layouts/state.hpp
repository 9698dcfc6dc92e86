// The state of a batch: where the positions and velocities lie, how many there are, and what time it is.
#pragma once

#include <array>
#include <cstddef>

#include "dvdx/layouts/column.hpp"

namespace dvdx {

// Scene time in seconds as an unevaluated sum, so that the phase of a forcing is right to 1e-9 rad after 1e6 s of small steps.
struct Clock {
  double seconds = 0;
  double carry = 0;  // what `seconds` could not hold

  // Moves by h * steps, the product and the sum both exact to twice double precision.
  void advance(double h, double steps) noexcept;
};

// Six columns (m and m/s) of one scalar type. Only pointers: copying a State copies no particle.
template <class T>
struct State {
  std::array<Column<T>, 3> x;  // position, m
  std::array<Column<T>, 3> v;  // velocity, m/s
  std::size_t count = 0;       // particles; every column's capacity must be at least this
  Clock clock{};
};

}  // namespace dvdx
