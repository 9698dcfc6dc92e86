// The particles of ranks that share the births of each step, and the messages between these ranks.
#pragma once

#include <cstdint>
#include <string>

#include "scale/prediction.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// Returns a text. If machine.particle_seconds is known, it also predicts a step with as many particles as may live.
[[nodiscard]] std::string table_of_births(const SceneFile& file, std::uint64_t ranks, const Machine& machine);

}  // namespace dvdx::tool
