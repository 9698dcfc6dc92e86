// Forces.
#pragma once

#include "scene_io/particle_values.hpp"

namespace dvdx::tool {

[[nodiscard]] Force read_force(const Node& node, const Population& population);

}  // namespace dvdx::tool
