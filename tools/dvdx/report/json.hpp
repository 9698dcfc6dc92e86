#pragma once

#include <nlohmann/json_fwd.hpp>

#include "report/results.hpp"

namespace dvdx::tool::report {

[[nodiscard]] nlohmann::ordered_json to_json(const Report& report);
[[nodiscard]] nlohmann::ordered_json to_json(const Machine& machine);

}  // namespace dvdx::tool::report
