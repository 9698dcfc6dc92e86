// Bodies that a scene's particles meet, as triangles.
#pragma once

#include <array>
#include <vector>

#include "dvdx/scene.hpp"
#include "output/raster.hpp"

namespace dvdx::tool {

using Patch = std::array<Corner, 3>;  // counter-clockwise, seen from where particles may be

// The contact where it is written. A plane has none: it has no end.
[[nodiscard]] std::vector<Patch> surface_of(const Contact& contact);

// Where a motion has what follows it. time: s.
[[nodiscard]] Pose pose_at(const Motion& motion, double time);
[[nodiscard]] Patch carried(const Patch& patch, const Motion& motion, const Pose& pose);

}  // namespace dvdx::tool
