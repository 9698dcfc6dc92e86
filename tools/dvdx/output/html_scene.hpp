// The scene, described for a page that plays states.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "output/writer.hpp"

namespace dvdx::tool {

// Returns n if one particle in n is shown. Joined particles are all shown, because lines and faces need them.
[[nodiscard]] std::size_t stride_of(const Output& output);

// Returns the rest length in m of each of the topology's lines; 0: its length at the start.
[[nodiscard]] std::vector<float> rest_lengths(const Output& output);

// Returns names, surroundings, their motions, pins and anchors. tools/viewer/src/playback/scene.ts has the keys.
[[nodiscard]] nlohmann::ordered_json scene_json(const Output& output);

}  // namespace dvdx::tool
