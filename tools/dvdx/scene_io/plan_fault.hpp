// The library's refusals of a scene, in the scene file's own words.
#pragma once

#include "dvdx/plan.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// A file names its motions where the library numbers them, meshes' triangles stand in files of their own, and networks have the
// keys of their coupling.
[[nodiscard]] Error in_words_of(const SceneFile& file, Error error);
[[nodiscard]] Fault fault_of(const SceneFile& file, Error error);

// Throws where a call that stepped the particles of `file` from `time` on, for so many seconds, was not done: Fault (bad_scene)
// where one had too many others within reach, else std::logic_error.
void check_stepped(StepResult result, const SceneFile& file, double time, double seconds);

}  // namespace dvdx::tool
