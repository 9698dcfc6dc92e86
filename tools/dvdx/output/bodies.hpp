// The bodies of a scene's contacts, as triangles.
#pragma once

#include <array>
#include <vector>

#include "dvdx/scene.hpp"
#include "output/raster.hpp"

namespace dvdx::tool {

using Patch = std::array<Corner, 3>;  // counter-clockwise, seen from where particles may be

// Returns a contact's surface where the scene puts it. A plane has none, because it has no end.
[[nodiscard]] std::vector<Patch> surface_of(const Contact& contact);

// Returns the pose that a motion gives its followers. time: s.
[[nodiscard]] Pose pose_at(const Motion& motion, double time);
[[nodiscard]] Patch carried(const Patch& patch, const Motion& motion, const Pose& pose);

}  // namespace dvdx::tool
