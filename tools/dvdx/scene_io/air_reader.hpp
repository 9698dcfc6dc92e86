// Air: the aerodynamics of a network's triangles, and the wind.
#pragma once

#include <optional>
#include <vector>

#include "dvdx/scene.hpp"
#include "scene_io/fields.hpp"

namespace dvdx::tool {

// Reads a network's key `aerodynamics`, if it has one.
[[nodiscard]] std::optional<Aerodynamics> read_aerodynamics(const Fields& network);

// Cuts faces into triangles from their first corner.
[[nodiscard]] std::vector<Triangle> triangles_of(const std::vector<std::vector<std::uint32_t>>& faces, std::size_t first);

// Reads the scene's key `wind`: [x, y, z], or a mean and gusts.
[[nodiscard]] Wind read_wind(const Node& node);

}  // namespace dvdx::tool
