// Particles that are in contact all the time.
#pragma once

#include "support/held.hpp"
#include "support/scenes.hpp"

namespace dvdx::bench {

// Hops on floor() that last just one frame, each particle at another phase: one impact a particle and step.
template <class T>
void start_hopping(State<T>& state) {
  scatter_about(state);
  const double g = 9.81, up = g * frame / 2;
  for (std::size_t i = 0; i < state.count; ++i) {
    const double t = frame * (0.1 + 0.8 * static_cast<double>(i % 101) / 100);
    state.x[1][i] = static_cast<T>(t * (up - g * t / 2));
    state.v[1][i] = static_cast<T>(up - g * t);
  }
}

// At rest on ground().
template <class T>
void start_resting(State<T>& state) {
  scatter_about(state);
  for (std::size_t i = 0; i < state.count; ++i) {
    state.x[1][i] = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) state.v[axis][i] = 0;
  }
}

}  // namespace dvdx::bench
