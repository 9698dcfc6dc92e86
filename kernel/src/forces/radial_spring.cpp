#include "forces/radial_spring.hpp"

#include "forces/spring.hpp"
#include "math/elementary.hpp"
#include "math/two_double_flow.hpp"

// Equation      x'' = -(W (r - l) + g r') n,  n = (x - c)/r, r = |x - c|, l the rest length
// Solution      none in closed form in space, as the direction n turns. Along a fixed direction it would be a spring's.
// Step          drift h/2; at the midpoint, where n is taken, the velocity's axial part u = n . v gets
//                 u <- E u,  u <- u - kappa (r - l),  u <- E u;      drift h/2
//               kappa = h W sinc^2(z/2),  E = exp(-g h/2)
//               Undamped motion along n: drift, kick, drift has trace 2 - h kappa = 2 cos z for this kappa (Gautschi's filter),
//               so the frequency is right and the step stable at every z. Damping before and after the kick in equal parts
//               keeps the step symmetric: it is its own inverse with -h, and so of second order, and E E = exp(-g h) damps
//               exactly where W = 0.
// Limits        z -> 0: kappa -> W h, leapfrog. z = 2 pi n: no kick. r = 0 has no direction: no kick.
// Coefficients  sinc^2(z/2) = 2 (1 - cos z)/z^2 = 2 psi_2(w,0).
// Other methods the spring's A, B, C, D along n, taken at the midpoint of the drift, with u = n . v and e = r - l - (h/2) u,
//               the distance there carried back to the start (flow/radial.hpp). n at the start, Brown's reading, would
//               be of first order in space.
// Source        Gautschi 1961; Hairer, Lubich, Wanner, XIII.1 (filtered leapfrog).

namespace dvdx {

RadialKick radial_kick(double W, double g, double h) noexcept {
  const PsiTable psi = flow(stiffness_number(W, h), 0.0);
  return {(two_product(W, 2.0 * h) * psi[2]).value(), exp_negative(0.5 * (g * h))};
}

Contribution radial_spring(double W, double g, double h, Method method) noexcept { return spring(W, g, h, method); }

}  // namespace dvdx
