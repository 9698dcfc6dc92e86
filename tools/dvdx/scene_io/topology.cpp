#include "scene_io/topology.hpp"

#include <algorithm>

namespace dvdx::tool {
namespace {

using SideOfFace = std::array<std::uint32_t, 2>;

SideOfFace ascending(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

}  // namespace

Topology without(const Topology& topology, std::span<const Tear> tears) {
  std::vector<SideOfFace> torn;
  for (const Tear& tear : tears) torn.push_back(ascending(tear.ends[0], tear.ends[1]));
  std::sort(torn.begin(), torn.end());
  const auto is_torn = [&](std::uint32_t a, std::uint32_t b) {
    return std::binary_search(torn.begin(), torn.end(), ascending(a, b));
  };
  Topology left;
  left.nets = topology.nets;
  for (const auto& line : topology.lines) {
    if (!is_torn(line[0], line[1])) left.lines.push_back(line);
  }
  for (const auto& face : topology.faces) {
    bool is_whole = true;
    for (std::size_t k = 0; k < face.size(); ++k) is_whole = is_whole && !is_torn(face[k], face[(k + 1) % face.size()]);
    if (is_whole) left.faces.push_back(face);
  }
  return left;
}

}  // namespace dvdx::tool
