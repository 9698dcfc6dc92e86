#pragma once

#include <nlohmann/json_fwd.hpp>

#include "report/results.hpp"

namespace dvdx::tool::report {

[[nodiscard]] nlohmann::ordered_json to_json(const Machine& machine);
[[nodiscard]] nlohmann::ordered_json to_json(const Report& report);

}  // namespace dvdx::tool::report
