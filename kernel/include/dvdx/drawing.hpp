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

// Writes the unit normal at each particle: the sum of the normals of the triangles that meet there, weighted by area, made a
// unit vector; zero if the sum is zero. A grid's triangles are its cells, each cut from (row, column) to (row + 1, column + 1).
// to[.][i] is the normal at particle grid.first + i. The bits do not depend on layout, instruction set or compiler. `to` must
// not overlap the state.
template <class T>
DVDX_EXPORT void normals(const Grid& grid, const State<T>& state, const std::array<Column<T>, 3>& to) noexcept;

// The same for any triangles and every particle of the state: to[.][i] is the normal at particle i, zero without a triangle.
// Every corner must be below the state's count.
template <class T>
DVDX_EXPORT void normals(std::span<const Triangle> triangles, const State<T>& state,
                         const std::array<Column<T>, 3>& to) noexcept;

// m, from the scene's origin. Without counted particles `least` is infinity and `most` is minus infinity.
struct Bounds {
  Vec3 least{};
  Vec3 most{};
  std::size_t particles = 0;  // counted: those with a finite position
};

template <class T>
[[nodiscard]] DVDX_EXPORT Bounds bounds(const State<T>& state) noexcept;

}  // namespace dvdx
