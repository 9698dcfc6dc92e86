// Tethers: which particle each hangs from, and how far along the springs.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "topology/particle_order.hpp"

namespace dvdx {

// The nearest fixed or kinematic particle of each particle of a network, and how far it is along whole springs.
struct TetherTo {
  std::optional<std::uint32_t> anchor{};  // none: no spring leads to one
  double length = 0;                      // m
};
[[nodiscard]] std::vector<TetherTo> tethers_of(std::span<const JoinedPair> springs, std::span<const double> w);

}  // namespace dvdx
