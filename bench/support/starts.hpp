// Starts: particles in permanent contact, or a hanging sheet.
#pragma once

#include "support/held.hpp"
#include "support/scenes.hpp"

namespace dvdx::bench {

// Hops on floor() that last exactly one frame, with a different phase for each particle: one impact a particle and step.
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

inline constexpr std::size_t sheet_side = 64;  // particles

// Flat and at rest, for hung_sheet().
inline Held<float> hung() {
  Held<float> held = hold_padded<float>(sheet_side * sheet_side);
  for (std::size_t i = 0; i < held.state.count; ++i) {
    held.state.x[0][i] = 2.0F * static_cast<float>(i % sheet_side) / (sheet_side - 1);
    held.state.x[1][i] = 0;
    held.state.x[2][i] = 2.0F * static_cast<float>(i / sheet_side) / (sheet_side - 1);
    for (std::size_t axis = 0; axis < 3; ++axis) held.state.v[axis][i] = 0;
  }
  return held;
}

// Held at two corners, under gravity.
inline Scene hung_sheet(Scheme scheme) {
  Scene scene;
  scene.mass = 1.0 / (sheet_side * sheet_side);
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Grid{.rows = sheet_side,
                 .columns = sheet_side,
                 .edge_u = {2, 0, 0},
                 .edge_v = {0, 0, 2},
                 .structural = 100,
                 .shear = 100,
                 .bend = 10});
  scene.coupling.scheme = scheme;
  scene.fixed = {0, sheet_side - 1};
  return scene;
}

}  // namespace dvdx::bench
