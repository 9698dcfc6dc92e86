// The exact flow of x'' + g x' + W x = a(t) over a step, in two doubles.
#pragma once

#include <array>

#include "math/psi.hpp"
#include "math/two_double.hpp"

namespace dvdx {

// psi_0 .. psi_max of (w, q) as psi.hpp defines them; the table is filled up to psi_top, 3 <= top <= psi_max.
using PsiTable = std::array<TwoDouble, psi_max + 1>;
PsiTable flow(TwoDouble w, TwoDouble q, int top = 3) noexcept;

// The velocity and position of an oscillator that was at rest at 0, after a unit of time under exp(i theta s), s = 0..1.
struct Complex {
  TwoDouble re, im;
};
struct Forced {
  Complex velocity, position;
};
Forced forced_flow(TwoDouble w, TwoDouble q, TwoDouble theta) noexcept;

// w = W h^2 and q = g h, exact to two doubles.
[[nodiscard]] inline TwoDouble stiffness_number(double W, double h) noexcept { return two_product(W, h) * h; }
[[nodiscard]] inline TwoDouble damping_number(double g, double h) noexcept { return two_product(g, h); }

}  // namespace dvdx
