#pragma once

#include <string_view>

namespace dvdx::tool::report {

extern const std::string_view compiler_flags;
extern const std::string_view page_template;  // report.html.in

}  // namespace dvdx::tool::report
