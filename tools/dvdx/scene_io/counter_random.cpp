#include "scene_io/counter_random.hpp"

#include <cmath>

namespace dvdx::tool {

double uniform_value(double min, double max, std::uint64_t seed, std::uint64_t particle, std::uint32_t axis) noexcept {
  const double value = min + (max - min) * unit_value(seed, particle, axis);
  return value < max || min == max ? value : std::nextafter(max, min);  // the sum may round up to max
}

}  // namespace dvdx::tool
