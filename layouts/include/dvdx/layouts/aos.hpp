// Array of structures: the caller's own particle struct, whatever else it holds.
#pragma once

#include <cstddef>

#include "dvdx/layouts/state.hpp"

namespace dvdx {

// A view of one scalar field of an array of n structs: first is the field in the first struct.
template <class T>
Column<T> field(T* first, std::size_t struct_bytes, std::size_t n) noexcept {
  return {first, static_cast<std::ptrdiff_t>(struct_bytes), 1, n};
}

// A view of n structs P that hold position and velocity as three consecutive T each, for example
//   struct Particle { float position[3]; float age; float velocity[3]; };
//   auto state = dvdx::aos(&p->position[0], &p->velocity[0], sizeof(Particle), n);
// Fields other than these six are never read or written.
template <class T>
State<T> aos(T* first_position, T* first_velocity, std::size_t struct_bytes, std::size_t n) noexcept {
  State<T> state{.x = {}, .v = {}, .count = n, .clock = {}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    state.x[axis] = field(first_position + axis, struct_bytes, n);
    state.v[axis] = field(first_velocity + axis, struct_bytes, n);
  }
  return state;
}

}  // namespace dvdx
