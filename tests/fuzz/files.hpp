// The folders with the files of the tried scenes, and their memory limit.
#pragma once

#include <cstdint>
#include <string>

namespace dvdx::fuzz {

[[nodiscard]] std::string files();   // the folder with a mesh, points and numbers
[[nodiscard]] std::string corpus();  // the folder with a folder of inputs for each target

inline constexpr std::uint64_t most_bytes = 1 << 20;

}  // namespace dvdx::fuzz
