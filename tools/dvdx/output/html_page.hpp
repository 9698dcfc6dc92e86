// The pages that tools/viewer builds: HTML files, complete except for the data that they show.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace dvdx::tool {

// A page cut where its data goes.
struct HtmlPage {
  std::string before;
  std::string after;
};

// Finds "playback" or "report" in the folder that the environment variable DVDX_VIEWER names; if it names none, in viewer/
// beside the program or in ../share/dvdx/viewer (installed). The error says what is missing and how to get it.
[[nodiscard]] tl::expected<HtmlPage, std::string> find_page(std::string_view name);

// Returns a <script type="text/x-dvdx-NAME"> element, whose text a browser leaves alone.
[[nodiscard]] std::string json_element(std::string_view name, const nlohmann::ordered_json& json);

}  // namespace dvdx::tool
