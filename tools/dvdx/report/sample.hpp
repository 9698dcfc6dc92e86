// Scenes made from a scene: fewer particles, another method.
#pragma once

#include <cstddef>

#include "scene_file.hpp"

namespace dvdx::tool::report {

// The scene with at most `most` of its particles, evenly spread over their numbers. Particles do not act on one another, so
// each moves as it did among all; where they do, the scene stays whole.
[[nodiscard]] SceneFile sample_of(const SceneFile& file, std::size_t most);

// The scene with one method for all forces.
[[nodiscard]] Scene with_method(Scene scene, Method method);

}  // namespace dvdx::tool::report
