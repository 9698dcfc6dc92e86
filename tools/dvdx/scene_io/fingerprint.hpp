// Whether two scenes are the same.
#pragma once

#include <cstdint>
#include <string>

#include "scene_io/scene_reader.hpp"

namespace dvdx::tool {

// 64 bits over what a scene says and over the bytes of the files that it names: the same however its JSON is written, but for
// `step` and `duration`, in whose place the file's own (which the command line may have replaced) are taken. Throws what
// read_scene throws.
[[nodiscard]] std::uint64_t fingerprint_of(const SceneFile& file, const ReadOptions& options);

}  // namespace dvdx::tool
