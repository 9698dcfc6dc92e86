// Radial springs as the radial pass reads them. The formulas of kappa and E and their sources: forces/radial_spring.cpp.
#pragma once

#include <array>

#include "flow/terms.hpp"

namespace dvdx {

// r = x - anchor, n = r/|r|, l is the rest length. |r| = 0 has no direction: n = 0 there, and the spring does nothing.
//
// Kick at the middle of the step, which has then reached (x1, v1); u = n.v1 of the moment:
//   every spring in list order     v += (E - 1) u n
//   every spring                   v -= kappa (|r| - l) n
//   every spring in reverse order  v += (E - 1) u n          a palindrome, so that a step with -h undoes it
// Contribution from the step's start, with the axis at the drifted midpoint: r = (x0 - anchor) + v0 h/2, u = n.v0,
//   e = |r| - l - (h/2) u        the stretch at the start, as far as the drift along n tells
//   dv = -(A e + B u) n,   dx = -(C e + D u) n
// (With the axis at x0 a spinning spring would gain energy, and the step would be of first order.)

// One radial spring. If a column pointer is null, the uniform value holds for all particles.
template <class T>
struct RadialTerms {
  T A = 0, B = 0, C = 0, D = 0;  // contribution along the axis (every method but combined)
  T kappa = 0, E = 1;            // kick at the middle of the step (combined): see forces/radial_spring.hpp
  T rest_length = 0;             // m
  std::array<T, 3> anchor{};     // m
  const T *A_each = nullptr, *B_each = nullptr, *C_each = nullptr, *D_each = nullptr;
  const T *kappa_each = nullptr, *E_each = nullptr;
  const T* rest_length_each = nullptr;
  AxisColumns<T> anchor_each{};
};

}  // namespace dvdx
