// Scenes that together reach every flow and every extra pass, and the particles' starts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "dvdx/layouts/state.hpp"
#include "dvdx/scene.hpp"
#include "flow/terms.hpp"

namespace dvdx::test {

struct NamedScene {
  std::string name;
  Scene scene;
  double step = 1.0 / 60;  // s
};

// A number in [0, 1) that depends on its two keys only.
[[nodiscard]] double uniform(std::uint64_t stream, std::uint64_t index) noexcept;

// For `count` particles: a scene for every flow, forces of every kind and method, fixed particles.
[[nodiscard]] std::vector<NamedScene> affine_scenes(std::size_t count);

[[nodiscard]] NamedScene with(NamedScene scene, StepFeatures features);

// Every affine scene unchanged, and for every flow a scene with contacts, with radial springs and with both.
[[nodiscard]] std::vector<NamedScene> all_scenes(std::size_t count);

// Positions within 1.2 m of the origin, velocities up to 3 m/s, each rounded once.
template <class T>
void place(State<T>& state) {
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.x[axis][i] = static_cast<T>(2.4 * uniform(axis, i) - 1.2);
      state.v[axis][i] = static_cast<T>(6 * uniform(3 + axis, i) - 3);
    }
  }
  state.clock = {};
}

}  // namespace dvdx::test
