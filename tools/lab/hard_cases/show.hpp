// The results of the hard cases as text and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "hard_cases/suite.hpp"

namespace dvdx::tool::stability {

enum class Colour { plain, coloured };

[[nodiscard]] std::string to_text(const std::vector<Row>& rows, Colour colour);
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<Row>& rows);

}  // namespace dvdx::tool::stability
