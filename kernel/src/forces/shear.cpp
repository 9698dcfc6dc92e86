#include "forces/shear.hpp"

#include <cmath>

#include "math/elementary.hpp"

// Equation      e'' = -W e - g e', e = x - c; z = omega h, q = g h
// Solution      e' = (1 - C) e + S v,  v' = -A e + (1 - B) v   (combined.cpp), a matrix of determinant exp(-q)
// Step          a matrix of determinant 1 - kappa is three shears (Paeth 1986; undamped, drift-kick-drift leapfrog with other
//               coefficients), the middle one of which also shrinks v:
//                 e += t1 v;  v -= s e + kappa v;  e += t2 v
//                 s = A,  t2 = C/A,  kappa = 1 - exp(-q),  t1 = S - t2 (1 - B)       undamped: t1 = t2 = tan(z/2)/omega
//               The determinant is 1 - kappa whatever the others round to: energy neither grows nor leaks, only the rounding of
//               the state walks at random. And x only ever receives the increment d: x = c + e would round by the same amount
//               at every step wherever c has more digits than e, which cost ten times the state error.
// Limits        t1, t2 have poles at z = pi: where the trace 2 - B - C is negative the matrix is -1 times one that turns by
//               z -+ pi, with C' = 2 - C, B' = 2 - B, A' = -A, S' = -S; then |t omega| <= 1. A = 0: t1 = t2 = S/(2 - kappa).
// Coefficients  from those of the combined step, which have all their digits.
// Source        Hairer, Lubich, Wanner, Geometric Numerical Integration, I.3 and VI.3 (symplecticity of such compositions).

namespace dvdx {

Shear shear(const Combined& exact, double g, double h) noexcept {
  const bool turned = exact.B + exact.C > 2.0;
  Shear result;
  result.sign = turned ? -1.0 : 1.0;
  const double C = turned ? 2.0 - exact.C : exact.C;
  const double B = turned ? 2.0 - exact.B : exact.B;
  const double S = result.sign * exact.S;
  result.s = result.sign * exact.A;
  result.kappa = -expm1_negative(g * h);
  const bool is_free = !(std::abs(result.s * S) > 1e-24);
  result.t2 = is_free ? S / (2.0 - result.kappa) : C / result.s;
  result.t1 = is_free ? result.t2 : S - result.t2 * (1.0 - B);
  result.kick = is_free ? 0.0 : (B + C) - result.kappa;
  return result;
}

}  // namespace dvdx
