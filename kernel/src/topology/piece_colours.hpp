// Colours of a list's springs that lead from piece to piece. They follow from what is fixed, too: who fixes a particle makes
// them anew.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "topology/particle_order.hpp"

namespace dvdx {

// For each spring, 0 where it stays in a piece or between two fixed ends; else its colour, from 1. w: of each particle, 0 where
// it is fixed.
[[nodiscard]] std::vector<std::uint32_t> colours_between_pieces(std::span<const JoinedPair> springs, const ParticleOrder& order,
                                                                std::span<const double> w);

}  // namespace dvdx
