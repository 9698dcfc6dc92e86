#include "forces/sinusoid.hpp"

#include "forces/combined.hpp"
#include "math/elementary.hpp"
#include "math/two_double.hpp"

// Equation      x'' = sin(Omega tau + phi), phi the phase at the step's start, theta = Omega h
// Solution      dv = h (sin(phi) sin(theta)/theta + cos(phi) (1 - cos theta)/theta)
//               dx = h^2 (sin(phi) (1 - cos theta)/theta^2 + cos(phi) (theta - sin theta)/theta^2)
// Limits        theta -> 0: a constant acceleration sin(phi). Every fraction above loses all its digits there, so none is used:
//               the gains are those of a free particle in combined_sinusoid, which are right at any theta.
// Step          exact: both. Average acceleration: dx = dv h/2. Pulse: dx = dv h. Symplectic Euler: dv = h sin(phi), dx = dv h.
// Coefficients  The phase is formed and reduced in two doubles: Omega t + phi is right to 1e-15 after 1e6 s of small steps.
// Source        Brown's kinematic integrator: forces that are known functions of time.

namespace dvdx {

Phase phase_at(double angular_frequency, double phase, const Clock& clock) noexcept {
  const TwoDouble time = two_sum(clock.seconds, clock.carry);
  const SinCos at = sincos(time * angular_frequency + phase);
  return {at.sin, at.cos};
}

SinusoidGains sinusoid(double angular_frequency, double h, Method method) noexcept {
  if (method == Method::symplectic_euler) return {{h, h * h}, {}};
  SinusoidGains gains = combined_sinusoid(0, 0, angular_frequency, h);
  const double share = method == Method::average_acceleration ? 0.5 * h : h;
  if (method == Method::average_acceleration || method == Method::pulse) {
    gains.in_phase.x = share * gains.in_phase.v;
    gains.quadrature.x = share * gains.quadrature.v;
  }
  return gains;
}

}  // namespace dvdx
