// Pairs of particles, and a value for each.
#pragma once

#include <optional>
#include <vector>

#include "scene_io/particle_values.hpp"

namespace dvdx::tool {

// Reads pairs of two different particles.
[[nodiscard]] std::vector<Pair> read_pairs(const Node& node, const Population& population);
// Reads a length for each pair, or none if lengths are those of the start.
[[nodiscard]] std::optional<Scalars> read_lengths(const Node& node, const Population& pairs, const Range& range);
// Returns the pairs as a population, for reading a value for each.
[[nodiscard]] Population population_of(const std::vector<Pair>& pairs, const Population& population);
// Adds the pairs to the lines that are drawn.
void add_lines(const std::vector<Pair>& pairs, SceneFile& file);

}  // namespace dvdx::tool
