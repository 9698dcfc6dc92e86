// Tells whether two scenes are the same.
#pragma once

#include <cstdint>
#include <string>

#include "scene_io/scene_reader.hpp"

namespace dvdx::tool {

// Returns a hash of 64 bits of a scene's JSON, however it is formatted, and of the bytes of the files that it names. `step` and
// `duration` are those of `file`, which the command line may have replaced. Throws what read_scene throws.
[[nodiscard]] std::uint64_t fingerprint_of(const SceneFile& file, const ReadOptions& options);

}  // namespace dvdx::tool
