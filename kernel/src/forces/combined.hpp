// All springs, drags and position-independent accelerations of a particle as one linear system, exact for any step.
#pragma once

#include "forces/contribution.hpp"
#include "forces/sinusoid.hpp"

namespace dvdx {

// One step of x'' = f - W (x - c) - g x'  with e = x - c:
//   dv = -A e - B v + constant.v f        dx = -C e - D v + constant.x f        S = h - D
// W and g are the sums over the particle's forces, c the stiffness-weighted mean of the anchors, and f all constant
// accelerations: gravity, and g_j u_j of each drag in wind.
struct Combined {
  double A = 0, B = 0, C = 0, D = 0, S = 0;
  Gain constant;
};

// Any h: negative runs back in time (finite for g h > -700), 0 is the identity.
Combined combined(double W, double g, double h) noexcept;

// The same in plain double by psi(). A wide body repeats it if W and g differ from particle to particle.
Combined combined_in_lanes(double W, double g, double h) noexcept;

// The gain of tau^k, k = 0..7 and tau the time since the step's start.
Gain combined_monomial(int k, double W, double g, double h) noexcept;

// The gains of sin(angular_frequency t + phase): at, near and far from resonance alike.
SinusoidGains combined_sinusoid(double W, double g, double angular_frequency, double h) noexcept;

}  // namespace dvdx
