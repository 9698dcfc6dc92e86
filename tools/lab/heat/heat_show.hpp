// The heat of ensembles as text, as JSON and as a picture.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "heat/heat.hpp"

namespace dvdx::tool::stability {

// One line for each stepping and group: the number of hot runs, and the largest share with its setting.
[[nodiscard]] std::string to_text(const std::vector<HeatRun>& runs);
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<HeatRun>& runs);

// "mesh 48x48, 10000 N/m, 2 sub-steps, float32, seed 7": omits further values that are a setting's defaults
[[nodiscard]] std::string text_of(const Setting& setting);

struct HeatPicture {
  std::string svg;      // a panel for each stepping: share over frequency times sub-step, a dot for each run
  std::string warning;  // the reason if there is no picture
};
[[nodiscard]] HeatPicture draw_heat(const std::vector<HeatRun>& runs);

}  // namespace dvdx::tool::stability
