#pragma once

#include <string>

#include "tune/tuning.hpp"

namespace dvdx::tool::tune {

// The findings, for a terminal.
[[nodiscard]] std::string to_text(const Tuning& tuning);

}  // namespace dvdx::tool::tune
