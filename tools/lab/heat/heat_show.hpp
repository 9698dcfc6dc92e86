// The heat of ensembles for a terminal, for machines and as a picture.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "heat/heat.hpp"

namespace dvdx::tool::stability {

// A line a stepping and group: how many runs are hot, and the largest share with its setting.
[[nodiscard]] std::string to_text(const std::vector<HeatRun>& runs);
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<HeatRun>& runs);

// "mesh 48x48, k 1e+04 N/m, 2 sub-steps": what a setting has beside its group's defaults
[[nodiscard]] std::string text_of(const Setting& setting);

struct HeatPicture {
  std::string svg;      // a panel a stepping: share over frequency times sub-step, a dot a run
  std::string warning;  // why there is none
};
[[nodiscard]] HeatPicture draw_heat(const std::vector<HeatRun>& runs);

}  // namespace dvdx::tool::stability
