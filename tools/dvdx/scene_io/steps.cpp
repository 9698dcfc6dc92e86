#include "scene_io/steps.hpp"

#include <fmt/format.h>

#include <cmath>

namespace dvdx::tool {

tl::expected<std::uint64_t, std::string> steps_in(double duration, double step) {
  const double steps = duration / std::abs(step);
  const double whole = std::round(steps);
  if (!(whole <= 0x1p53)) return tl::unexpected(fmt::format("at most 2^53 steps of {} s, and is {:.3g} of them", step, steps));
  const bool is_less_than_one = whole == 0 && duration != 0;
  if (!(std::abs(steps - whole) <= 1e-6) || is_less_than_one) {
    return tl::unexpected(fmt::format("a whole number of steps of {} s, and is {} of them", step, steps));
  }
  return static_cast<std::uint64_t>(whole);
}

}  // namespace dvdx::tool
