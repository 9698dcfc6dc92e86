// Scenes made from a scene: fewer or more particles, another method.
#pragma once

#include <cstddef>

#include "report/results.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool::report {

// The scene with at most `most` of its particles, evenly spread over their numbers. Particles do not act on one another, so
// each moves as it did among all; where they do, the scene stays whole.
[[nodiscard]] SceneFile sample_of(const SceneFile& file, std::size_t most);

// The scene with `count` of its particles, evenly spread over their numbers, and some of them several times where it has fewer.
// Nothing may join them; `count` must be at least 1.
[[nodiscard]] SceneFile resized(const SceneFile& file, std::size_t count);

// Errors are measured on at most this many particles. Where the reference is stepped it costs far more than the runs.
[[nodiscard]] std::size_t most_error_particles(const SceneFile& file, Effort effort);

// The scene with one method for all forces.
[[nodiscard]] Scene with_method(Scene scene, Method method);

}  // namespace dvdx::tool::report
