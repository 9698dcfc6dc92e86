#pragma once

#include <string_view>

namespace dvdx::tool {

extern const std::string_view version;   // of dvdx
extern const std::string_view compiler;  // that built this binary

}  // namespace dvdx::tool
