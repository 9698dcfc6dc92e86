// The state of a batch: the columns of positions and velocities, the particle count, and the time.
#pragma once

#include <array>
#include <cstddef>

#include "dvdx/layouts/column.hpp"

namespace dvdx {

// Scene time in seconds as an unevaluated sum, so that the phase of a forcing is right to 1e-9 rad after 1e6 s of small steps.
struct Clock {
  double seconds = 0;
  double carry = 0;  // the part that `seconds` cannot hold

  // Advances by h * steps; the product and the sum are exact to twice double precision.
  void advance(double h, double steps) noexcept;
  [[nodiscard]] bool is_finite() const noexcept;  // neither part is infinite or NaN
};

// Six columns (m and m/s) of one scalar type. A State is a view: copying it copies no particle.
template <class T>
struct State {
  std::array<Column<T>, 3> x;  // position, m, from the scene's origin
  std::array<Column<T>, 3> v;  // velocity, m/s
  std::size_t count = 0;       // particles; every column's capacity must be at least this
  Clock clock{};
  // For compensated plans alone (capacity 0 elsewhere): residuals, the parts that x and v cannot hold. The represented number
  // is the sum, to 48 bits if T is float.
  std::array<Column<T>, 3> x_rest{};
  std::array<Column<T>, 3> v_rest{};

  [[nodiscard]] bool has_rests() const noexcept { return x_rest[0].base != nullptr; }
};

// Returns `state` with the columns of `rests` as its residuals. Both must have the same count. The caller sets the residuals to
// zero if the state holds its numbers exactly.
template <class T>
[[nodiscard]] State<T> compensated(State<T> state, const State<T>& rests) noexcept {
  state.x_rest = rests.x;
  state.v_rest = rests.v;
  return state;
}

}  // namespace dvdx
