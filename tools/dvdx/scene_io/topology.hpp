// What joins a scene's particles, for pictures: the springs' and constraints' lines, and the faces of its grids and meshes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace dvdx::tool {

struct Topology {
  std::vector<std::array<std::uint32_t, 2>> lines;  // of networks of springs and distance constraints
  std::vector<std::vector<std::uint32_t>> faces;    // a grid's quads, a mesh's own polygons
  bool operator==(const Topology&) const = default;
};

}  // namespace dvdx::tool
