// What a page that plays states is told of the scene.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>

#include "output/writer.hpp"

namespace dvdx::tool {

// One particle in so many is shown. Joined particles are all needed for their lines and faces.
[[nodiscard]] std::size_t stride_of(const Output& output);

// Names, surroundings, what moves them, pins and anchors: tools/viewer/src/playback/scene.ts has the keys.
[[nodiscard]] nlohmann::ordered_json scene_json(const Output& output);

}  // namespace dvdx::tool
