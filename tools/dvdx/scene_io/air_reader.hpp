// Air: what a network's triangles meet, and the wind.
#pragma once

#include <optional>
#include <vector>

#include "dvdx/scene.hpp"
#include "scene_io/fields.hpp"

namespace dvdx::tool {

// A network's key `aerodynamics`, if it has one.
[[nodiscard]] std::optional<Aerodynamics> read_aerodynamics(const Fields& network);

// Faces cut into triangles from their first corner.
[[nodiscard]] std::vector<Triangle> triangles_of(const std::vector<std::vector<std::uint32_t>>& faces, std::size_t first);

// The scene's key `wind`: [x, y, z], or a mean and gusts.
[[nodiscard]] Wind read_wind(const Node& node);

}  // namespace dvdx::tool
