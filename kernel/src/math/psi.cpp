#include "math/psi.hpp"

#include <cmath>

#include "math/elementary.hpp"
#include "math/two_double_flow.hpp"

// Equation   y'' + q y' + w y = 1 in a unit of time: a step of x'' = -W x - g x' + f in units of h. Roots of mu^2 + q mu + w.
// Solution   psi_1 is the response to a unit pulse, psi_2 to a unit force, psi_3 to a unit ramp: divided differences of exp at
//            0 (k-1 times) and at both roots (Hochbruck and Ostermann, Acta Numerica 2010, for a matrix; this is the 2x2 case).
// Limits     psi_k(0,0) = 1/k!,  psi_k(0,q) = phi_k(-q),  psi_1(w,0) = sinc sqrt(w).
// Forms      b = q/2, d = b^2 - w. The three regimes (oscillating, critical, overdamped) share
//              psi_1 = exp(-b) sinh(sg)/sg sin(om)/om,   sg = sqrt(max(d,0)), om = sqrt(max(-d,0)), one of them 0,
//            where exp(-b) sinh(sg)/sg is written exp(near) phi_1(-2 sg), near being the root that decays slower, so that
//            nothing overflows. If w is not small against q^2, psi_2 and psi_3 follow from the recurrence. Otherwise the
//            divided difference of phi_1, phi_2 at the two roots, which are then far apart, is better conditioned; for small
//            arguments Taylor's series is. Selects join the three, as every lane may be in another regime.
// Time runs backwards with q < 0: the roots change sign, and the same forms hold with the growing root as `near`.

namespace dvdx {
namespace {

struct Phi {
  double phi1, phi2;
};

// phi_1(x) = (exp x - 1)/x, phi_2(x) = (phi_1(x) - 1)/x.
Phi phi(double x, double expm1) noexcept {
  double series = inverse_factorials[phi_series_terms + 1];
  for (std::size_t n = phi_series_terms; n >= 2; --n) series = series * x + inverse_factorials[n];
  const bool small = (x < 0 ? -x : x) < phi_series_limit;
  const double divisor = small ? 1.0 : x;
  const double direct = expm1 / divisor;
  return {small ? 1.0 + x * series : direct, small ? series : (direct - 1.0) / divisor};
}

Psi taylor(double w, double q) noexcept {
  double d = 1;
  double next = -q;
  double psi1 = 0, psi2 = 0, psi3 = 0;
  for (std::size_t n = 0; n < psi_taylor_terms; ++n) {
    psi1 = psi1 + d * inverse_factorials[n + 1];
    psi2 = psi2 + d * inverse_factorials[n + 2];
    psi3 = psi3 + d * inverse_factorials[n + 3];
    const double after = -(q * next + w * d);
    d = next;
    next = after;
  }
  return {1.0 - (q * psi1 + w * psi2), psi1, psi2, psi3};
}

}  // namespace

Psi psi(double w_any, double q_any) noexcept {
  const double w = w_any < psi_huge ? w_any : psi_huge;
  const double q = q_any < psi_huge_root ? q_any : psi_huge_root;
  const double b = 0.5 * q;
  const double size = b < 0 ? -b : b;
  const double root_w = std::sqrt(w);
  const double d = (size - root_w) * (size + root_w);
  const double sg = std::sqrt(d > 0 ? d : 0.0);
  const double om = std::sqrt(d < 0 ? -d : 0.0);

  // The two decay rates, the small one without cancellation. In the oscillating regime both are b.
  const double large = size + sg;
  const double quotient = w / (large > psi_tiny ? large : psi_tiny);
  const double small = quotient < size ? quotient : size;
  const double near = q < 0 ? large : -small;
  const double far = q < 0 ? small : -large;
  const ExpNegative exp_near = exp_pair_negative(-near);
  const ExpNegative exp_gap = exp_pair_negative(2.0 * sg);
  const SinCos turn = sincos(om);
  const double sinc = om < sinc_series_limit ? 1.0 - (om * om) * (1.0 / 6) : turn.sin / (om > 0 ? om : 1.0);
  const double phi_gap = phi(-2.0 * sg, exp_gap.expm1).phi1;
  const double psi1 = (exp_near.exp * phi_gap) * sinc;
  const double even = (exp_near.exp * (1.0 + 0.5 * exp_gap.expm1)) * turn.cos;
  const double psi0 = even - b * psi1;

  const double divisor = w > psi_tiny ? w : psi_tiny;
  const double recurrent2 = (1.0 - (even + b * psi1)) / divisor;
  const double recurrent3 = ((1.0 - psi1) - q * recurrent2) / divisor;

  const Phi phi_near = phi(near, exp_near.expm1);
  const Phi phi_far = phi(far, exp_near.exp * (1.0 + exp_gap.expm1) - 1.0);
  const double gap = sg > psi_tiny ? 2.0 * sg : psi_tiny;
  const double divided2 = (phi_near.phi1 - phi_far.phi1) / gap;
  const double divided3 = (phi_near.phi2 - phi_far.phi2) / gap;

  const bool apart = d > 0.25 * (b * b);
  const bool tiny = w <= psi_taylor_limit && 2.0 * size <= psi_taylor_limit;
  const Psi series = taylor(w, q);
  return {tiny ? series.psi0 : psi0, tiny ? series.psi1 : psi1, tiny ? series.psi2 : (apart ? divided2 : recurrent2),
          tiny ? series.psi3 : (apart ? divided3 : recurrent3)};
}

double psi_k(int k, double w, double q) noexcept { return flow(w, q, psi_max)[static_cast<std::size_t>(k)].value(); }

}  // namespace dvdx
