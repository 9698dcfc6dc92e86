#include "state/health.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "state/slices.hpp"

namespace dvdx::tool {

namespace {

template <class T>
Health health_of(const State<T>& state, std::size_t first, std::size_t end) noexcept {
  Health health;
  for (std::size_t i = first; i < end; ++i) {
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

}  // namespace

template <class T>
Health health_of(const State<T>& state, const ParallelFor& parallel) noexcept {
  std::array<Health, most_slices> slices{};
  for_each_slice(parallel, state.count,
                 [&](std::size_t slice, std::size_t first, std::size_t end) { slices[slice] = health_of(state, first, end); });
  Health health;
  for (const Health& slice : slices) {
    health.bad_particles += slice.bad_particles;
    health.largest = std::max(health.largest, slice.largest);
  }
  return health;
}

bool has_diverged(const Health& start, const Health& end) noexcept {
  return end.bad_particles > 0 || end.largest > most_growth * std::max(1.0, start.largest);
}

template Health health_of(const State<float>&, const ParallelFor&) noexcept;
template Health health_of(const State<double>&, const ParallelFor&) noexcept;

}  // namespace dvdx::tool
