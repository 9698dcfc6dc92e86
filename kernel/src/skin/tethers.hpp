// Tethers: the particle that each one hangs from, and the distance to it along the springs. How they hold: ball.hpp.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "topology/particle_order.hpp"

namespace dvdx {

// For a particle of a network: the nearest fixed or kinematic particle, and the distance to it along whole springs.
struct TetherTo {
  std::optional<std::uint32_t> anchor{};  // none: no spring leads to one
  double length = 0;                      // m
};
[[nodiscard]] std::vector<TetherTo> tethers_of(std::span<const JoinedPair> springs, std::span<const double> w);

}  // namespace dvdx
