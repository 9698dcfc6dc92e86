#pragma once

#include <string>

#include "report/pictures.hpp"

namespace dvdx::tool::report {

// One page that needs nothing beside it: tables, pictures and the machine.
[[nodiscard]] std::string to_html(const Report& report, const Pictures& pictures);

}  // namespace dvdx::tool::report
