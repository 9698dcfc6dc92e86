// Layers of cloth that start nearer than they want to be, and so never meet (NearAtStart::pass).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "dvdx/values.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {

// Counts the pairs that are no neighbours: the path between them along springs and rods is more than twice what the pair wants,
// or there is none. wanted(i, j), m, at most `most`: the distance wanted by a pair that is nearer and would otherwise meet; 0
// for any other. The count stops at the number of particles, and after 1024 tests for each, far more than cloth needs.
[[nodiscard]] std::size_t count_passing_layers(std::span<const JoinedPair> joined, std::span<const Vec3> start, double most,
                                               const std::function<double(std::uint32_t, std::uint32_t)>& wanted);

}  // namespace dvdx
