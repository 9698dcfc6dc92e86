// Layers of cloth that start nearer than they want to be, and so never meet (NearAtStart::pass).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "dvdx/values.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {

// Pairs that are no neighbours: the way along what joins particles from one to the other is more than twice what the pair
// wants, or there is none. wanted(i, j), m, at most `most`: of a pair that is nearer than that and would meet; 0 of any other.
// As many as there are particles are counted, no more, and so many times as many looked at that a cloth has by far fewer.
[[nodiscard]] std::size_t count_passing_layers(std::span<const JoinedPair> joined, std::span<const Vec3> start, double most,
                                               const std::function<double(std::uint32_t, std::uint32_t)>& wanted);

}  // namespace dvdx
