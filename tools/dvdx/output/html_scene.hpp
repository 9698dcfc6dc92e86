// The scene, described for a page that plays states.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "output/writer.hpp"

namespace dvdx::tool {

// One particle in so many is shown. Joined particles are all needed for their lines and faces.
[[nodiscard]] std::size_t stride_of(const Output& output);

// m: of each of the topology's lines, its length at rest; 0: what it has at the start.
[[nodiscard]] std::vector<float> rest_lengths(const Output& output);

// Names, surroundings, what moves them, pins and anchors: tools/viewer/src/playback/scene.ts has the keys.
[[nodiscard]] nlohmann::ordered_json scene_json(const Output& output);

}  // namespace dvdx::tool
