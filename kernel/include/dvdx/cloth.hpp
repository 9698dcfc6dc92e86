// Cloth from the triangles that a program draws.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "dvdx/export.h"
#include "dvdx/layouts/state.hpp"
#include "dvdx/network.hpp"
#include "dvdx/values.hpp"

namespace dvdx {

// Returns the sides of triangles, each once, the lesser number first, ascending.
[[nodiscard]] DVDX_EXPORT std::vector<Pair> edges(std::span<const Triangle> triangles);
// Returns the corners across each side that exactly two triangles share, likewise: springs between them resist bending.
[[nodiscard]] DVDX_EXPORT std::vector<Pair> bend_pairs(std::span<const Triangle> triangles);

struct Cloth {
  double stretch = 0;  // N/m >= 0, of springs along the sides
  double bend = 0;     // N/m >= 0, of springs across them; 0: none. add_bending() bends by angles instead
  double damping = 0;  // kg/s >= 0, along each spring
  std::optional<Aerodynamics> air{};
};
// Returns the springs of a triangle mesh. Their rest lengths are the distances when the plan is compiled. The triangles meet
// narrow bodies (Faces).
[[nodiscard]] DVDX_EXPORT Springs springs_of(std::span<const Triangle> triangles, const Cloth& cloth);

// to = (1 - t) before + t after for positions and velocities, to draw between two steps. All have one count, in any layout.
template <class T>
void blend(const State<T>& before, const State<T>& after, double t, State<T>& to) noexcept {
  const std::size_t count = std::min({before.count, after.count, to.count});
  const auto part = static_cast<T>(t);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < count; ++i) {
      to.x[axis][i] = before.x[axis][i] + part * (after.x[axis][i] - before.x[axis][i]);
      to.v[axis][i] = before.v[axis][i] + part * (after.v[axis][i] - before.v[axis][i]);
    }
  }
}

}  // namespace dvdx
