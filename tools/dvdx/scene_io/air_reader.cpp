#include "scene_io/air_reader.hpp"

#include "scene_io/described.hpp"

namespace dvdx::tool {
std::optional<Aerodynamics> read_aerodynamics(const Fields& network) {
  const auto node = network.optional("aerodynamics");
  if (!node) return std::nullopt;
  if (!node->json().is_object()) node->refuse("an object with density, drag and lift");
  return DescribedReader{}.read<Aerodynamics>(*node);
}

std::vector<Triangle> triangles_of(const std::vector<std::vector<std::uint32_t>>& faces, std::size_t first) {
  const auto at = [first](std::uint32_t vertex) { return static_cast<std::uint32_t>(first + vertex); };
  std::vector<Triangle> triangles;
  for (const auto& face : faces) {
    for (std::size_t k = 2; k < face.size(); ++k) triangles.push_back({at(face[0]), at(face[k - 1]), at(face[k])});
  }
  return triangles;
}

Wind read_wind(const Node& node) {
  if (node.json().is_array()) return {.mean = node.vector()};
  if (!node.json().is_object()) node.refuse("three numbers, or an object with mean and gusts");
  return DescribedReader{}.read<Wind>(node);
}

}  // namespace dvdx::tool
