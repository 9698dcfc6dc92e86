// The report on the page that tools/viewer builds: the page draws, this file supplies the numbers.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <tl/expected.hpp>

namespace dvdx::tool::report {

// `report` has the contents of report.json. Adds the result of `dvdx stability --out` if the folder holds it. The error gives
// the reason why there is no page.
[[nodiscard]] tl::expected<std::string, std::string> to_page(const nlohmann::ordered_json& report,
                                                             const std::filesystem::path& folder);

}  // namespace dvdx::tool::report
