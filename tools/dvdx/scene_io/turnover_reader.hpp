// A scene's emitters, capacity and removal.
#pragma once

#include <string_view>

#include "scene_io/fields.hpp"
#include "scene_io/motion_reader.hpp"
#include "scene_io/particle_values.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// Whether the scene has any of the keys.
[[nodiscard]] bool has_turnover(const Fields& scene);

// Reads them. `room`: for the particles, of which the capacity is the most. The scene's own particles have been read.
void read_turnover(const Fields& scene, SceneFile& file, const MotionNames& motions, const Room& room);

// For commands that compare particles with a reference: throws Fault (bad_scene) where they come and go.
void refuse_turnover(const SceneFile& file, std::string_view command);

}  // namespace dvdx::tool
