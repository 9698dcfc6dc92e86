// Grids: their keys, and the particles, springs and faces that follow from them.
#pragma once

#include <array>
#include <cstddef>

#include "scene_io/fields.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

struct GridKeys {
  Grid grid;
  Vec3 origin{};
  double mass = 0;  // kg, of all particles
};
[[nodiscard]] GridKeys read_grid(const Fields& fields);

[[nodiscard]] SheetVectors positions_of(const GridKeys& keys);
// Returns the corner particles: no particle is farther out along an axis than one of them.
[[nodiscard]] std::array<std::size_t, 4> corners_of(const Grid& grid);

[[nodiscard]] inline bool is_rope(const Grid& grid) noexcept { return grid.rows == 1 || grid.columns == 1; }
// Returns a grid of one row or one column as the list of its springs.
[[nodiscard]] Springs rope_of(const Grid& grid);

// Limits the sides of its cells to 1 + limit times their length in the flat sheet.
[[nodiscard]] Distance limit_of(const Grid& grid, double limit);
[[nodiscard]] Topology topology_of(const Grid& grid, std::size_t first);

}  // namespace dvdx::tool
