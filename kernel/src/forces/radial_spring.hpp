// A spring with a rest length from an anchor: the coefficients of its kick along the axis.
#pragma once

#include "dvdx/method.hpp"
#include "forces/contribution.hpp"

namespace dvdx {

// The midpoint kick of Method::combined, along the axis n at the drifted midpoint x + v h/2, with u = n . v:
//   u <- E u,   u <- u - kappa (r - rest_length),   u <- E u
struct RadialKick {
  double kappa = 0;  // 1/s
  double E = 1;
};
RadialKick radial_kick(double W, double g, double h) noexcept;

// The other methods take spring()'s coefficients along the axis at the drifted midpoint, with e = r - rest_length - (h/2) u.
Contribution radial_spring(double W, double g, double h, Method method) noexcept;

}  // namespace dvdx
