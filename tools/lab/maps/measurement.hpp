// How fast the same systems grow when the library steps them: compiled plans in float64, run from starts that span the state.
#pragma once

#include <span>
#include <vector>

#include "dvdx/isa.hpp"
#include "maps/analysis.hpp"
#include "maps/bounce.hpp"

namespace dvdx::tool::stability {

// The steps after which a run is looked at double from 1 to this; of each system the last look counts at which the state can
// still be told from rounding and from what is out of its range.
inline constexpr std::size_t most_steps = 256;

// Growth of the amplitude per step of h = 1 s: the spectral radius of what the run made of the starts, to the power 1/steps.
// All systems are one batch of particles, so all have as many springs and the same expansion, and either none or all of them a
// damped first spring; for lines, the same scheme. Throws std::runtime_error where the library refuses a scene.
[[nodiscard]] std::vector<double> measured_growth(std::span<const Anchored> particles, Method method,
                                                  Arithmetic arithmetic = Arithmetic::separate);
[[nodiscard]] std::vector<double> measured_growth(std::span<const Line> lines, const Coupling& coupling,
                                                  Arithmetic arithmetic = Arithmetic::separate);
// Growth of the energy in a step of 1 s with a bounce: the mean over the starts of starts_of. All bounces have the same gravity
// and differ in no more of the impact than in restitution.
[[nodiscard]] std::vector<double> measured_growth(std::span<const Bounce> bounces,
                                                  Arithmetic arithmetic = Arithmetic::separate);

}  // namespace dvdx::tool::stability
