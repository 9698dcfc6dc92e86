// The number of steps in a duration.
#pragma once

#include <cstdint>
#include <string>
#include <tl/expected.hpp>

namespace dvdx::tool {

// Returns duration / |step|, a whole number within 1e-6 and 0 only for no duration; otherwise a text of valid durations.
[[nodiscard]] tl::expected<std::uint64_t, std::string> steps_in(double duration, double step);

}  // namespace dvdx::tool
