// A file that one rank writes or several: each its own parts, the first one what is alike for all.
#pragma once

#include <cstdint>
#include <filesystem>

#include "dvdx/ranks.hpp"
#include "files/byte_stream.hpp"

namespace dvdx::tool {

struct Stored {
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;
};

// Writes what `save` makes to the file from `place` on. All ranks have the file open, and all learn of the whole. Throws
// SharedFault (input_output) on all of them. To be called by all.
[[nodiscard]] Stored write_together(Ranks& ranks, int descriptor, const std::filesystem::path& file, std::uint64_t place,
                                    const SaveRun& save);

}  // namespace dvdx::tool
