// Reads a scene's constraints.
#pragma once

#include "scene_io/particle_values.hpp"

namespace dvdx::tool {

// Adds constraints to the scene.
void read_constraints(const Node& constraints, SceneFile& file, const Population& population, ReadTopology topology);

}  // namespace dvdx::tool
