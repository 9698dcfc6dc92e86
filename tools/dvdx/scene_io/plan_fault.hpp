// The library's refusals of a scene, in the scene file's own words.
#pragma once

#include "dvdx/plan.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// Renames the error's field: a file has names for motions that the library numbers, mesh triangles in files of their own, and
// the coupling's keys in networks.
[[nodiscard]] Error in_words_of(const SceneFile& file, Error error);
[[nodiscard]] Fault fault_of(const SceneFile& file, Error error);

// Throws if a call that stepped the particles of `file` from `time` on, for `seconds`, was not done: Fault (bad_scene) if a
// particle had too many others within reach, otherwise std::logic_error.
void check_stepped(StepResult result, const SceneFile& file, double time, double seconds);

}  // namespace dvdx::tool
