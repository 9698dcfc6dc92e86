// Seeded values of a scene.
#pragma once

#include <cstdint>

#include "dvdx/counter_random.hpp"

namespace dvdx::tool {

// Returns a value in [min, max), or min if they are equal.
[[nodiscard]] double uniform_value(double min, double max, std::uint64_t seed, std::uint64_t particle,
                                   std::uint32_t axis) noexcept;

}  // namespace dvdx::tool
