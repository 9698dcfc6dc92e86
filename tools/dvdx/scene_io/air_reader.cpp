#include "scene_io/air_reader.hpp"

namespace dvdx::tool {
namespace {

constexpr Range coefficient{.min = 0, .max = 1e6, .text = "a number from 0 to 1e6"};

Gust read_gust(const Node& node) {
  const Fields fields(node, "a gust", {"amplitude", "angular_frequency", "phase"});
  return {.amplitude = fields.required("amplitude").vector(),
          .angular_frequency = fields.required("angular_frequency").number(),
          .phase = fields.number("phase", any_number, 0)};
}

}  // namespace

std::optional<Aerodynamics> read_aerodynamics(const Fields& network) {
  const auto node = network.optional("aerodynamics");
  if (!node) return std::nullopt;
  if (!node->json().is_object()) node->refuse("an object with density, drag and lift");
  const Fields fields(*node, "the aerodynamics of a network", {"density", "drag", "lift"});
  const Aerodynamics otherwise;
  return Aerodynamics{.density = fields.number("density", not_negative, otherwise.density),
                      .drag = fields.number("drag", coefficient, otherwise.drag),
                      .lift = fields.number("lift", coefficient, otherwise.lift)};
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
  const Fields fields(node, "a wind", {"mean", "gusts"});
  Wind wind{.mean = fields.vector("mean", {})};
  if (const auto gusts = fields.optional("gusts")) {
    for (const auto& gust : gusts->elements("a list of gusts")) wind.gusts.push_back(read_gust(gust));
  }
  return wind;
}

}  // namespace dvdx::tool
