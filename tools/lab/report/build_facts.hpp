#pragma once

#include <string_view>

namespace dvdx::tool::report {

extern const std::string_view compiler_flags;

}  // namespace dvdx::tool::report
