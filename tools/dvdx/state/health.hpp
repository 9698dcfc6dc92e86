// Whether a state's numbers are still finite and plausible.
#pragma once

#include <cstddef>

#include "dvdx/layouts/state.hpp"
#include "dvdx/parallel.hpp"

namespace dvdx::tool {

struct Health {
  std::size_t bad_particles = 0;  // particles with a number that is not finite
  double largest = 0;             // of the finite positions and velocities, m or m/s
};

template <class T>
[[nodiscard]] Health health_of(const State<T>& state, const ParallelFor& parallel = {}) noexcept;

// No scene grows by this factor through its own forces.
inline constexpr double most_growth = 1e15;

// Returns true if a number is not finite, or larger by most_growth than the largest at the start (and than 1).
[[nodiscard]] bool has_diverged(const Health& start, const Health& end) noexcept;

extern template Health health_of(const State<float>&, const ParallelFor&) noexcept;
extern template Health health_of(const State<double>&, const ParallelFor&) noexcept;

}  // namespace dvdx::tool
