#pragma once

#include <string>
#include <string_view>

#include "report/pictures.hpp"

namespace dvdx::tool::report {

// One page that needs nothing beside it: tables, pictures and the machine. `notice` stands above them.
[[nodiscard]] std::string to_html(const Report& report, const Pictures& pictures, std::string_view notice = {});

}  // namespace dvdx::tool::report
