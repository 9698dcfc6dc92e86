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
  [[nodiscard]] bool is_finite() const noexcept;  // neither part is infinite or not a number
};

// Six columns (m and m/s) of one scalar type. Only pointers: copying a State copies no particle.
template <class T>
struct State {
  std::array<Column<T>, 3> x;  // position, m, from the scene's origin
  std::array<Column<T>, 3> v;  // velocity, m/s
  std::size_t count = 0;       // particles; every column's capacity must be at least this
  Clock clock{};
  // For compensated plans alone (capacity 0 elsewhere): residuals, what the value beside it could not hold. The number meant is
  // the sum, to 48 bits where T is float.
  std::array<Column<T>, 3> x_rest{};
  std::array<Column<T>, 3> v_rest{};

  [[nodiscard]] bool has_rests() const noexcept { return x_rest[0].base != nullptr; }
};

// `state` with the columns of `rests` as its residuals. Both must have the same count; residuals start at zero where
// the state holds its numbers exactly.
template <class T>
[[nodiscard]] State<T> compensated(State<T> state, const State<T>& rests) noexcept {
  state.x_rest = rests.x;
  state.v_rest = rests.v;
  return state;
}

}  // namespace dvdx
