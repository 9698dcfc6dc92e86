// The stability maps as text, as JSON and as pictures.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "maps/growth_map.hpp"

namespace dvdx::tool::stability {

// One line for each map: where it grows, and the largest difference between analysis and measurement.
[[nodiscard]] std::string to_text(const std::vector<GrowthMap>& maps);
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<GrowthMap>& maps);

struct MapPicture {
  std::string file;  // springs.svg
  std::string svg;
};
struct MapPictures {
  std::vector<MapPicture> all;  // one for each family: a heat map of the measured growth for each method
  std::string warning;          // the reason if there are none
};
[[nodiscard]] MapPictures draw_maps(const std::vector<GrowthMap>& maps);

}  // namespace dvdx::tool::stability
