// Particles that meet one another: the scene's key `meet`.
#pragma once

#include "scene_io/particle_values.hpp"

namespace dvdx::tool {

void read_meet(const Fields& scene, SceneFile& file, const Population& population);

}  // namespace dvdx::tool
