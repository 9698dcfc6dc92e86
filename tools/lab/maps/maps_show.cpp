#include "maps/maps_show.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace dvdx::tool::stability {
namespace {

using Json = nlohmann::ordered_json;  // values that are not finite become null

std::string limits_text(const GrowthMap& map) {
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  std::size_t nowhere = 0;
  for (const double limit : map.limits) {
    if (std::isnan(limit)) {
      ++nowhere;
    } else {
      least = std::min(least, limit);
      most = std::max(most, limit);
    }
  }
  const std::size_t rows = map.limits.size();
  if (nowhere == rows) return "nowhere";
  std::string text = fmt::format("{:.4g}", least);
  if (most == 0) text = "everywhere";
  if (most - least > 5e-4 * most) text += fmt::format(" to {:.4g}", most);
  if (nowhere != 0) text += fmt::format(", nowhere in {} of {} rows", nowhere, rows);
  return text;
}

std::string line_of(const GrowthMap& map) {
  const Agreement found = agreement_of(map);
  std::string line = fmt::format("  {:<33} {:<42} {:>2}  {:>8.1e}  {}\n", map.method, limits_text(map), found.boundary_cells,
                                 found.growth_difference, found.is_good() ? "agree" : "DISAGREE");
  if (found.boundary_cells > 1)
    line += fmt::format("      boundary farthest apart at {} = {:.4g}\n", map.y.name, found.boundary_y);
  if (found.growth_difference > growth_within) {
    line += fmt::format("      growth farthest apart at {} = {:.4g}, {} = {:.4g}\n", map.x.name, found.growth_x, map.y.name,
                        found.growth_y);
  }
  return line;
}

Json json_of(const Axis& axis) {
  return {
      {"name", axis.name}, {"spacing", axis.spacing == Spacing::linear ? "linear" : "logarithmic"}, {"values", axis.values}};
}

Json rows_of(const GrowthMap& map, const std::vector<double>& growth) {
  auto rows = Json::array();
  for (std::size_t k = 0; k < map.y.values.size(); ++k) {
    const auto row = map.row(growth, k);
    rows.push_back(std::vector<double>(row.begin(), row.end()));
  }
  return rows;
}

Json json_of(const GrowthMap& map) {
  const Agreement found = agreement_of(map);
  return {{"name", map.name},
          {"title", map.title},
          {"method", map.method},
          {"x", json_of(map.x)},
          {"y", json_of(map.y)},
          {"analysed", rows_of(map, map.analysed)},
          {"measured", rows_of(map, map.measured)},
          {"limits", map.limits},
          {"agreement",
           {{"agrees", found.is_good()},
            {"boundary_cells", found.boundary_cells},
            {"boundary_y", found.boundary_y},
            {"growth_difference", found.growth_difference},
            {"growth_x", found.growth_x},
            {"growth_y", found.growth_y}}}};
}

}  // namespace

std::string to_text(const std::vector<GrowthMap>& maps) {
  if (maps.empty()) return "";
  std::string text;
  const GrowthMap* before = nullptr;
  for (const GrowthMap& map : maps) {
    if (before == nullptr || before->name != map.name) {
      text += fmt::format("{}: {}\n  {:<33} {:<42} {:>2}  {:>8}\n", map.name, map.title, "", "grows beyond " + map.x.name,
                          "cells", "growth");
    }
    text += line_of(map);
    before = &map;
  }
  const auto apart = std::count_if(maps.begin(), maps.end(), [](const GrowthMap& map) { return !agreement_of(map).is_good(); });
  if (apart != 0) return text + fmt::format("FAILED: analysis and measurement disagree on {} of {} maps\n", apart, maps.size());
  return text + fmt::format("analysis and measurement agree on all {} maps: boundaries within a cell, growths within {:.0e}\n",
                            maps.size(), growth_within);
}

nlohmann::ordered_json to_json(const std::vector<GrowthMap>& maps) {
  auto json = Json::array();
  for (const GrowthMap& map : maps) json.push_back(json_of(map));
  return json;
}

}  // namespace dvdx::tool::stability
