// The exact step, damped or not, is derived in combined.cpp.
#include "forces/spring.hpp"

#include "forces/combined.hpp"

// Equation      e'' = -W e - g e', e = x - c; z = omega h, q = g h
// Solution      undamped: e = e0 cos(omega t) + (v0/omega) sin(omega t); damped: the psi functions of psi.hpp
// Step          exact       dv = -A e - B v,  dx = -C e - D v,  from the solution over one step; undamped
//                           A = omega sin z,  B = C = 1 - cos z,  D = h - sin(z)/omega
//               average     dv as exact,  dx = dv h/2
//               pulse       dv as exact,  dx = dv h
//               Euler       dv = -(W e + g v) h,  dx = dv h
// Limits        W = g = 0: nothing. z -> 0: A -> W h, D -> z^2 h/6. Large z: A, B, C, D stay bounded;
//               a single exact spring has det = 1, average has det = 1 - z^4/24 + ..., pulse cos z. Several exact springs have
//               det = 1 + (z^4 - sum z_i^4)/12, which grows: use Method::combined for them.
// Coefficients  1 - cos z and z - sin z are never formed as such: combined.cpp.
// Source        Brown's kinematic integrator (the exact, average acceleration and pulse modes of a spring).

namespace dvdx {

Contribution by_method(const Combined& exact, double W, double g, double h, Method method) noexcept {
  switch (method) {
    case Method::symplectic_euler:
      return {W * h, g * h, W * h * h, g * h * h};
    case Method::average_acceleration:
      return {exact.A, exact.B, 0.5 * h * exact.A, 0.5 * h * exact.B};
    case Method::pulse:
      return {exact.A, exact.B, h * exact.A, h * exact.B};
    case Method::combined:
    case Method::exact:
      break;
  }
  return {exact.A, exact.B, exact.C, exact.D};
}

Contribution spring(double W, double g, double h, Method method) noexcept {
  return by_method(combined(W, g, h), W, g, h, method);
}

}  // namespace dvdx
