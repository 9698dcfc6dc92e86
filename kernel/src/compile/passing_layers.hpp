// Layers of cloth that start nearer than they want to be, and so never meet (NearAtStart::pass).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "compile/particle_order.hpp"
#include "dvdx/values.hpp"

namespace dvdx {

// Pairs within what they want at the start, `most` m or less, that are no neighbours: the way along springs from one to the
// other is more than twice that, or there is none. passes(i, j), i < j: whether the pair would meet, and is nearer than that.
[[nodiscard]] std::size_t count_passing_layers(std::span<const JoinedPair> springs, std::span<const Vec3> start, double most,
                                               const std::function<bool(std::uint32_t, std::uint32_t)>& passes);

}  // namespace dvdx
