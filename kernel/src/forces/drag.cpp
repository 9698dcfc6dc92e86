#include "forces/drag.hpp"

#include "forces/combined.hpp"
#include "forces/spring.hpp"

// Equation      x'' = -g (v - u), q = g h; u is the wind
// Solution      v - u = (v0 - u) exp(-g t)
// Step          exact       dv = -(1 - exp(-q)) (v - u),  dx = -h (1 - (1 - exp(-q))/q) (v - u)
//               average, pulse and Euler as for a spring
//               A wind adds B u to dv and D u to dx.
// Limits        q -> 0: B -> q, D -> q h/2. q -> inf: B -> 1, D -> h: the particle moves with the wind from the start. First
//               order (Brown's shortcut 1 - exp(-q) = q): dx = -h q/2 (v - u) in the exact mode, as dx by Brown's own
//               first-order reading would be 0. It reverses the velocity for q > 1, and is unstable for q > 2.
// Coefficients  1 - exp(-q) and q - (1 - exp(-q)) are never formed as such: it is a spring with W = 0 (combined.cpp).
// Source        Brown's kinematic integrator (viscous drag).

namespace dvdx {

Contribution drag(double g, double h, Method method, Expansion expansion) noexcept {
  if (expansion == Expansion::exact || method == Method::symplectic_euler) return spring(0, g, h, method);
  const double q = g * h;
  return {0, q, 0, method == Method::pulse ? h * q : 0.5 * h * q};
}

}  // namespace dvdx
