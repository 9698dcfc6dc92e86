// Oscillating motion as three shears, by which rounding neither gives nor takes energy.
#pragma once

#include "forces/combined.hpp"

namespace dvdx {

// e = x - c:   p = t1 v,  u = v - (s (e + p) + kappa v),  d = p + t2 u
//   x' = x + d,  v' = u                                            where sign is +1
//   x' = x + ((sign - 1) e + sign d),  v' = sign u                 in either case
struct Shear {
  double sign = 1, t1 = 0, s = 0, t2 = 0, kappa = 0;
  double kick = 0;  // s (t1 + t2), which with kappa determines the eigenvalues; 0 if the motion was taken for free
};

// exact: the combined step for W, g and h, of motion that is free or oscillates, W > (g/2)^2. If undamped, |t omega| <= 1.
Shear shear(const Combined& exact, double g, double h) noexcept;

}  // namespace dvdx
