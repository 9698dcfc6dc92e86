// Bytes packed as zlib does it (RFC 1950), which browsers unpack by themselves.
#pragma once

#include <string>
#include <string_view>

namespace dvdx::tool {

[[nodiscard]] std::string deflated(std::string_view bytes);

}  // namespace dvdx::tool
