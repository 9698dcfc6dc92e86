#include "output/html_page.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <vector>

#include "scene_io/file_text.hpp"

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view data_mark = "<!-- dvdx data -->";

std::vector<fs::path> page_folders() {
  const char* named = std::getenv("DVDX_VIEWER");  // NOLINT(concurrency-mt-unsafe): read only
  if (named != nullptr && *named != '\0') return {named};
  std::error_code error;
  const auto program = fs::read_symlink("/proc/self/exe", error).parent_path();
  return {program / "viewer", program.parent_path() / "share" / "dvdx" / "viewer"};
}

std::optional<HtmlPage> cut(const std::string& text) {
  const auto at = text.find(data_mark);
  if (at == std::string::npos) return std::nullopt;
  return HtmlPage{.before = text.substr(0, at), .after = text.substr(at + data_mark.size())};
}

}  // namespace

tl::expected<HtmlPage, std::string> find_page(std::string_view name) {
  const auto file = fmt::format("{}.html", name);
  std::string looked_for;
  for (const auto& folder : page_folders()) {
    const auto path = folder / file;
    looked_for += (looked_for.empty() ? "" : " and ") + path.string();
    const auto text = read_file(path);
    if (!text) continue;
    if (auto page = cut(*text)) return *std::move(page);
    return tl::unexpected(path.string() + " is no page of dvdx");
  }
  return tl::unexpected(
      fmt::format("the {} page has not been built: there is no {}. `tools/run.sh demo` in dvdx's source builds "
                  "it (with Node.js and npm); or let DVDX_VIEWER name the folder that has it",
                  name, looked_for));
}

std::string json_element(std::string_view name, const nlohmann::ordered_json& json) {
  auto text = json.dump();
  for (auto at = text.find('<'); at != std::string::npos; at = text.find('<', at)) text.replace(at, 1, "\\u003c");
  return fmt::format("<script type=\"text/x-dvdx-{}\">{}</script>\n", name, text);
}

}  // namespace dvdx::tool
