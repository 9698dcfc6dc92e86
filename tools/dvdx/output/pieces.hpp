// The topology of a scene, cut into pieces as ranks have them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "scene_io/topology.hpp"

namespace dvdx::tool {

struct RankPiece {
  std::vector<std::uint32_t> particles;  // numbers in the whole: its own, ascending, then those of others that its cells reach
  std::size_t own = 0;
  Topology topology;                              // by indices in `particles`
  std::vector<std::array<std::size_t, 1>> loose;  // its own that no line and no face of any piece holds; likewise
};

// owner: the piece of each particle, below `count`. A line or face belongs to the piece that owns its first corner.
[[nodiscard]] std::vector<RankPiece> pieces_of(const Topology& topology, std::span<const std::uint32_t> owner,
                                               std::size_t count);

}  // namespace dvdx::tool
