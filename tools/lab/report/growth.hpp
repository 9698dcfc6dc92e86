// The growth of a small difference of the start of joined particles. Beyond too large a growth, positions cannot be compared.
#pragma once

#include <cstdint>
#include <vector>

#include "report/simulation.hpp"

namespace dvdx::tool::report {

// A start's difference that has grown by more than this ends the horizon: the errors of a run have grown by as much.
inline constexpr double most_growth = 1000;

// The difference of the positions, root mean square over all particles that are not fixed, relative to that of the start.
// Sampled at intervals until it has grown far beyond the limit.
struct Growth {
  double nudge = 0;                     // m: the difference of the start
  std::vector<std::uint64_t> counts{};  // sample times in the scene's own steps, from 0
  std::vector<double> at{};             // the largest growth so far
  std::uint64_t horizon = 0;            // the scene's own steps up to the last sample before the limit, or to the end
  bool is_whole = true;                 // the limit was never exceeded
};

// Uses leapfrog in float64 with the sub-steps that it chooses. Two kinds of scenes are not measured, and their horizon is the
// end: those with a closed form, which holds however much differences grow, and those that leapfrog refuses. If setup.end comes
// first, the last sample is the horizon, and is_whole is false.
[[nodiscard]] Growth growth_of(const SceneFile& file, std::uint64_t steps, const Setup& setup);

}  // namespace dvdx::tool::report
