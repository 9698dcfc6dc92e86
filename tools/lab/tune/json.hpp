#pragma once

#include <nlohmann/json_fwd.hpp>

#include "tune/tuning.hpp"

namespace dvdx::tool::tune {

[[nodiscard]] nlohmann::ordered_json to_json(const report::Machine& machine, const Tuning& tuning);

}  // namespace dvdx::tool::tune
