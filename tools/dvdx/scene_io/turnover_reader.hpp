// A scene's emitters, capacity and removal.
#pragma once

#include <string_view>

#include "scene_io/fields.hpp"
#include "scene_io/motion_reader.hpp"
#include "scene_io/particle_values.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// Whether the scene has any of these keys.
[[nodiscard]] bool has_turnover(const Fields& scene);

// Reads these keys. room: for as many particles as the capacity. The scene's own particles must have been read before.
void read_turnover(const Fields& scene, SceneFile& file, const MotionNames& motions, const Room& room);

// Throws Fault (bad_scene) if particles come and go, for commands that compare particles with a reference.
void refuse_turnover(const SceneFile& file, std::string_view command);

}  // namespace dvdx::tool
