// An acceleration that is a sine of time.
#pragma once

#include "dvdx/layouts/state.hpp"
#include "dvdx/method.hpp"
#include "forces/contribution.hpp"

namespace dvdx {

// sin and cos of the phase at the start of a step.
struct Phase {
  double sin = 0, cos = 1;
};
Phase phase_at(double angular_frequency, double phase, const Clock& clock) noexcept;

// dv = A (in_phase.v * start.sin + quadrature.v * start.cos), dx likewise with .x; A is the acceleration's amplitude.
struct SinusoidGains {
  Gain in_phase, quadrature;
};

// Method::combined is the exact one here (with springs or drag: combined_sinusoid).
SinusoidGains sinusoid(double angular_frequency, double h, Method method) noexcept;

}  // namespace dvdx
