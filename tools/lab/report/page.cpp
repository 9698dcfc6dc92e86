#include "report/page.hpp"

#include <nlohmann/json.hpp>

#include "output/html_page.hpp"
#include "scene_io/file_text.hpp"

namespace dvdx::tool::report {

tl::expected<std::string, std::string> to_page(const nlohmann::ordered_json& report, const std::filesystem::path& folder) {
  const auto page = find_page("report");
  if (!page) return tl::unexpected(page.error());
  auto html = page->before + json_element("report", report);
  const auto stability = read_file(folder / "stability.json");
  const auto maps = stability ? nlohmann::ordered_json::parse(*stability, nullptr, false) : nlohmann::ordered_json();
  if (maps.is_object()) html += json_element("stability", maps);  // other files are not ours
  return html + page->after;
}

}  // namespace dvdx::tool::report
