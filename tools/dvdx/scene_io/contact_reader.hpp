// Contacts: reads the keys that are no plain fields. Plain fields: dvdx/fields.hpp, scene_io/described.hpp.
#pragma once

#include "scene_io/fields.hpp"
#include "scene_io/motion_reader.hpp"
#include "scene_io/scene_folder.hpp"

namespace dvdx::tool {

[[nodiscard]] Contact read_contact(const Node& node, const MotionNames& motions, SceneFolder& folder);
// Reads the scene's key `push_out`, for contacts that have no such speed of their own.
void read_push_out(const Node& node, Scene& scene);

}  // namespace dvdx::tool
