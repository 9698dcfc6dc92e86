// How a small difference of the start of joined particles grows: where that is too much, positions cannot be compared.
#pragma once

#include <cstdint>
#include <vector>

#include "report/simulation.hpp"

namespace dvdx::tool::report {

// A difference of the start that has grown by more than this ends the horizon: a run's own errors have grown as much.
inline constexpr double most_growth = 1000;

// Root mean square over all particles that are not fixed, over that of the start. Looked at from time to time, until it has
// grown by far too much.
struct Growth {
  double nudge = 0;                     // m: the difference of the start
  std::vector<std::uint64_t> counts{};  // looks, in the scene's own steps, from 0 on
  std::vector<double> at{};             // the largest until then
  std::uint64_t horizon = 0;            // own steps: of the last look before it was too much, or of the end
  bool is_whole = true;                 // it never was
};

// By leapfrog in float64, with sub-steps that it chooses by itself. None is found for a scene with a closed form, which holds
// however much differences grow, nor for one that leapfrog refuses: the horizon is then the end.
// Where setup.end comes first its last look is the horizon, and is not the whole.
[[nodiscard]] Growth growth_of(const SceneFile& file, std::uint64_t steps, const Setup& setup);

}  // namespace dvdx::tool::report
