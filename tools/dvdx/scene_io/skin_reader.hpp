// Skins and tethers, which hold particles near something.
#pragma once

#include <optional>

#include "scene_io/motion_reader.hpp"
#include "scene_io/network_reader.hpp"

namespace dvdx::tool {

// Adds the skins of `fields`; networks: of the scene, if it has any.
void read_skins(const Fields& fields, Scene& scene, const Population& population, const MotionNames& motions,
                const std::optional<NetworkReader>& networks);

void read_tethers(const Fields& fields, Scene& scene);

}  // namespace dvdx::tool
