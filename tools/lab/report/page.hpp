// The report on the page that tools/viewer builds: the page draws, this gives it the numbers.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <tl/expected.hpp>

namespace dvdx::tool::report {

// `report` as it stands in report.json, and what `dvdx stability --out` left in the folder, if it did. The error says why there
// is no such page.
[[nodiscard]] tl::expected<std::string, std::string> to_page(const nlohmann::ordered_json& report,
                                                             const std::filesystem::path& folder);

}  // namespace dvdx::tool::report
