// The growth of the same systems when the library steps them: compiled plans in float64, run from starts that span the state.
#pragma once

#include <span>
#include <vector>

#include "dvdx/isa.hpp"
#include "maps/analysis.hpp"
#include "maps/bounce.hpp"

namespace dvdx::tool::stability {

// A run is sampled after 1, 2, 4, ... steps, up to this number. The last sample at which the state is clear of rounding and
// within its range counts.
inline constexpr std::size_t most_steps = 256;

// Growth of the amplitude per step of h = 1 s: the spectral radius of the image of the starts, to the power 1/steps. All
// systems are one batch of particles, so they have the same number of springs and the same expansion, and either all or none
// have a damped first spring; lines have the same scheme. Throws std::runtime_error if the library refuses a scene.
[[nodiscard]] std::vector<double> measured_growth(std::span<const Anchored> particles, Method method,
                                                  Arithmetic arithmetic = Arithmetic::separate);
[[nodiscard]] std::vector<double> measured_growth(std::span<const Line> lines, const Coupling& coupling,
                                                  Arithmetic arithmetic = Arithmetic::separate);
// Growth of the energy in a step of 1 s with a bounce, averaged over starts_of. All bounces have the same gravity, and their
// impacts differ only in restitution.
[[nodiscard]] std::vector<double> measured_growth(std::span<const Bounce> bounces,
                                                  Arithmetic arithmetic = Arithmetic::separate);

}  // namespace dvdx::tool::stability
