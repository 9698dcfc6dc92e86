// The stability maps: each method over the number of springs, damping and step, each scheme over mass ratio, springs and step,
// and the impact over restitution and step.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "dvdx/isa.hpp"
#include "maps/growth_map.hpp"

namespace dvdx::tool::stability {

enum class Detail {
  whole,
  coarse,  // a ninth of the cells along each axis
};

// tell(maps done, total, next map) is called before each map.
using TellMap = std::function<void(std::size_t, std::size_t, const std::string&)>;
[[nodiscard]] std::vector<GrowthMap> make_maps(Detail detail, Arithmetic arithmetic, const TellMap& tell);

[[nodiscard]] bool all_agree(const std::vector<GrowthMap>& maps);

}  // namespace dvdx::tool::stability
