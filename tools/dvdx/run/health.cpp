#include "run/health.hpp"

#include <algorithm>
#include <cmath>

namespace dvdx::tool {

template <class T>
Health health_of(const State<T>& state) noexcept {
  Health health;
  for (std::size_t i = 0; i < state.count; ++i) {
    bool is_finite = true;
    for (const auto* columns : {&state.x, &state.v}) {
      for (const auto& column : *columns) {
        const auto size = std::abs(static_cast<double>(column[i]));
        is_finite = is_finite && std::isfinite(size);
        if (std::isfinite(size)) health.largest = std::max(health.largest, size);
      }
    }
    health.bad_particles += is_finite ? 0 : 1;
  }
  return health;
}

bool has_diverged(const Health& start, const Health& end) noexcept {
  return end.bad_particles > 0 || end.largest > most_growth * std::max(1.0, start.largest);
}

template Health health_of(const State<float>&) noexcept;
template Health health_of(const State<double>&) noexcept;

}  // namespace dvdx::tool
