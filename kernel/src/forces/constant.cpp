#include "forces/constant.hpp"

#include "forces/polynomial.hpp"

// Equation      x'' = 1
// Solution      v = v0 + t, x = x0 + v0 t + t^2/2
// Step          dv = h; dx = h^2/2 (exact; average acceleration agrees), h^2 (pulse, symplectic Euler)
// Source        Brown's kinematic integrator: the contribution of a force is its integral over the step.

namespace dvdx {

Gain constant(double h, Method method) noexcept { return monomial(0, h, method); }

}  // namespace dvdx
