// How many steps a duration is.
#pragma once

#include <cstdint>
#include <string>
#include <tl/expected.hpp>

namespace dvdx::tool {

// duration / |step|, which must be a whole number within 1e-6 and none only of no duration; else what a duration must be.
[[nodiscard]] tl::expected<std::uint64_t, std::string> steps_in(double duration, double step);

}  // namespace dvdx::tool
