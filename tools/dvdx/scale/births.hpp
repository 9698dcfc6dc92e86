// The particles of ranks that share the births of each step, and what these ranks tell each other.
#pragma once

#include <cstdint>
#include <string>

#include "scale/prediction.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// In words. Where the machine's time of a particle is known, also what a step would take with as many particles as may live.
[[nodiscard]] std::string table_of_births(const SceneFile& file, std::uint64_t ranks, const Machine& machine);

}  // namespace dvdx::tool
