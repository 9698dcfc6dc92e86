// The rate pass: the exact coefficients of particles that differ in mass, stiffness or drag, made in the lanes.
#pragma once

#include <cstddef>

namespace dvdx {

// Arrays of `count` (a multiple of 16) float64. In: W = stiffness/mass >= 0, 1/s^2, and g = damping/mass >= 0, 1/s. Out: the
// combined step of forces/combined.hpp; X = h^2 psi_2 is the position's gain of a constant acceleration (S is the velocity's).
// The error is at most 6 eps of float64, or 2 z eps of the amplitude for z = sqrt(W) |h| > 1; z must not exceed sincos_fast
// (math/elementary.hpp).
struct RateRun {
  std::size_t count = 0;
  double h = 0;  // s
  const double* W = nullptr;
  const double* g = nullptr;
  double *A = nullptr, *B = nullptr, *C = nullptr, *S = nullptr, *X = nullptr;
};

using RatePass = void (*)(const RateRun&);

// The response of the same particles to sin and cos of a forcing's phase: in_v sin + quad_v cos in dv, in_x and quad_x in dx.
// One Taylor series gives both (derived in rate_reference.hpp). It holds for W h^2, |g h| and |theta| up to psi_taylor_limit
// (math/psi.hpp), and has no division.
struct RateSinusoid {
  std::size_t count = 0;
  double h = 0;
  double theta = 0;  // angular frequency times h, rad
  const double* W = nullptr;
  const double* g = nullptr;
  double *in_v = nullptr, *in_x = nullptr, *quad_v = nullptr, *quad_x = nullptr;
};

using RateSinusoidPass = void (*)(const RateSinusoid&);

}  // namespace dvdx
