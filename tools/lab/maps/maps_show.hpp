// The stability maps for a terminal, for machines and as pictures.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "maps/growth_map.hpp"

namespace dvdx::tool::stability {

// A line a map: where it grows, and how far analysis and measurement lie apart.
[[nodiscard]] std::string to_text(const std::vector<GrowthMap>& maps);
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<GrowthMap>& maps);

struct MapPicture {
  std::string file;  // springs.svg
  std::string svg;
};
struct MapPictures {
  std::vector<MapPicture> all;  // one a family: a heat map of the measured growth a method
  std::string warning;          // why there are none
};
[[nodiscard]] MapPictures draw_maps(const std::vector<GrowthMap>& maps);

}  // namespace dvdx::tool::stability
