// Coefficients rounded to float together, so that the errors that would add up over steps cancel.
#pragma once

#include "forces/combined.hpp"
#include "forces/shear.hpp"

namespace dvdx {

struct ShearF {
  float sign = 1, t1 = 0, s = 0, t2 = 0, kappa = 0;
};

struct FusedF {
  float A = 0, B = 0, C = 0, S = 0;
};

// How far, in units in the last place, a coefficient may be from the exact one.
inline constexpr int paired_reach = 2;

// The step: shear.hpp.
ShearF paired(const Shear& exact) noexcept;

// e = x - c;  x' = x + ((S v - C e) + Q);  v' = v + (P - (A e + B v)).
FusedF paired(const Combined& exact) noexcept;

}  // namespace dvdx
