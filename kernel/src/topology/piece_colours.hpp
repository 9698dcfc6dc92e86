// Colours of a list's springs that lead from piece to piece. They depend on what is fixed: fixing a particle needs new colours.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "topology/particle_order.hpp"

namespace dvdx {

// For each spring, 0 if it stays in a piece or between two fixed ends; otherwise its colour, from 1. w: of each particle, 0
// where it is fixed.
[[nodiscard]] std::vector<std::uint32_t> colours_between_pieces(std::span<const JoinedPair> springs, const ParticleOrder& order,
                                                                std::span<const double> w);

}  // namespace dvdx
