// A file that one rank or several write: each writes its own parts, and the first also the bytes that all share.
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

// Writes the output of `save` to the file from byte `place` on, and returns size and CRC of the whole on every rank. All ranks
// have the file open, and all must call it. Throws SharedFault (input_output) on all of them.
[[nodiscard]] Stored write_together(Ranks& ranks, int descriptor, const std::filesystem::path& file, std::uint64_t place,
                                    const SaveRun& save);

}  // namespace dvdx::tool
