// The lines and faces that join a scene's particles, for pictures: lines of springs and constraints, faces of grids and meshes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace dvdx::tool {

struct Topology {
  std::vector<std::array<std::uint32_t, 2>> lines;   // of networks of springs and distance constraints
  std::vector<std::vector<std::uint32_t>> faces;     // a grid's quads, a mesh's own polygons
  std::vector<std::array<std::uint32_t, 2>> nets{};  // grids that are no cloth: the first particle of each, and how many
  bool operator==(const Topology&) const = default;
};

// Whether a scene's lines and faces are read. Only its output needs them: a face takes more memory than its particle.
enum class ReadTopology { yes, no };

// A spring of a network that tore at the end of a step.
struct Tear {
  std::uint64_t step = 0;
  std::size_t network = 0;
  std::array<std::uint32_t, 2> ends{};
};

// Returns the topology that is left after these tears. A face goes with the spring along one of its sides.
[[nodiscard]] Topology without(const Topology& topology, std::span<const Tear> tears);

}  // namespace dvdx::tool
