// Scenes derived from a scene: fewer or more particles, another method.
#pragma once

#include <cstddef>

#include "report/results.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool::report {

// The scene with at most `most` of its particles, evenly spread over their indices. Particles that do not act on one another
// move as in the whole scene. If they do, the scene stays whole.
[[nodiscard]] SceneFile sample_of(const SceneFile& file, std::size_t most);

// The scene with `count` particles, evenly spread over their indices. Particles are repeated if the scene has fewer. The
// particles must not be joined, and `count` must be at least 1.
[[nodiscard]] SceneFile resized(const SceneFile& file, std::size_t count);

// The limit of particles on which errors are measured. A stepped reference costs far more than the runs.
[[nodiscard]] std::size_t most_error_particles(const SceneFile& file, Effort effort);

// The scene with one method for all forces.
[[nodiscard]] Scene with_method(Scene scene, Method method);

}  // namespace dvdx::tool::report
