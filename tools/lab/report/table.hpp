#pragma once

#include <string>

#include "report/results.hpp"

namespace dvdx::tool::report {

// The report for a terminal.
[[nodiscard]] std::string to_text(const Report& report);

}  // namespace dvdx::tool::report
