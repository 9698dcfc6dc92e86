// Pairs of particles, and a value for each.
#pragma once

#include <optional>
#include <vector>

#include "scene_io/particle_values.hpp"

namespace dvdx::tool {

// Each of two particles.
[[nodiscard]] std::vector<Pair> read_pairs(const Node& node, const Population& population);
// One for each pair, or none where they are those of the start.
[[nodiscard]] std::optional<Scalars> read_lengths(const Node& node, const Population& pairs, const Range& range);
// The pairs, for whose values it asks.
[[nodiscard]] Population population_of(const std::vector<Pair>& pairs, const Population& population);
// Adds them to what is drawn.
void add_lines(const std::vector<Pair>& pairs, SceneFile& file);

}  // namespace dvdx::tool
