// Bytes as text.
#pragma once

#include <string>
#include <string_view>

namespace dvdx::tool {

[[nodiscard]] std::string base64(std::string_view bytes);

}  // namespace dvdx::tool
