// Geometry for drawing a state: normals at the corners of sheets and meshes, and the box that holds the particles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dvdx/export.h"
#include "dvdx/layouts/state.hpp"
#include "dvdx/network.hpp"

namespace dvdx {

// Three particles; the normal is that of (second - first) x (third - first).
using Triangle = std::array<std::uint32_t, 3>;

// The sum of the normals of the triangles that meet at a particle, each weighed by its area, at unit length; zero where that
// sum is. A grid's triangles are its cells, each cut from (row, column) to (row + 1, column + 1), and to[.][i] is the normal at
// particle grid.first + i. Each is the same whatever the layout, instruction set and compiler. `to` must not overlap the state.
template <class T>
DVDX_EXPORT void normals(const Grid& grid, const State<T>& state, const std::array<Column<T>, 3>& to) noexcept;

// The same for any triangles and every particle of the state: to[.][i] is the normal at particle i, zero where no triangle is.
// The triangles must not name particles that the state does not have.
template <class T>
DVDX_EXPORT void normals(std::span<const Triangle> triangles, const State<T>& state,
                         const std::array<Column<T>, 3>& to) noexcept;

// m, from the scene's origin. Without particles `least` is infinite, and `most` minus infinity.
struct Bounds {
  Vec3 least{};
  Vec3 most{};
  std::size_t particles = 0;  // that are counted: those whose place is finite
};

template <class T>
[[nodiscard]] DVDX_EXPORT Bounds bounds(const State<T>& state) noexcept;

}  // namespace dvdx
