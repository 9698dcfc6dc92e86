// The rate pass, wide: exponential, sine, cosine and psi in the lanes, operation by operation as in math/elementary.cpp and
// math/psi.cpp, which derive them. It is never contracted: coefficients have the same bits in every arithmetic.
#pragma once

#include <cstddef>

#include "flow/rate.hpp"
#include "math/elementary.hpp"
#include "math/psi.hpp"
#include "simd/lanes.hpp"

namespace dvdx {
namespace {

template <class V>
V rounded(V x) noexcept {
  return (x + V(round_magic)) - V(round_magic);
}

template <class V>
V power_of_two(V n) noexcept {
  const auto is_negative = n < V(0.0);
  V rest = magnitude(n);
  V power(1.0);
  double bit = 512;
  for (const double up : {0x1p+512, 0x1p+256, 0x1p+128, 0x1p+64, 0x1p+32, 0x1p+16, 0x1p+8, 0x1p+4, 0x1p+2, 0x1p+1}) {
    const auto has = rest >= V(bit);
    power = power * select<V>(has, select<V>(is_negative, V(1.0 / up), V(up)), V(1.0));
    rest = rest - select<V>(has, V(bit), V(0.0));
    bit *= 0.5;
  }
  return power;
}

template <class V>
struct ExpLanes {
  V exp, expm1;
};

template <class V>
ExpLanes<V> exp_lanes(V x) noexcept {
  const V low = select<V>(x < V(-exp_zero), V(-exp_zero), x);
  const V clamped = select<V>(low > V(exp_zero), V(exp_zero), low);
  const V n = rounded(negative(clamped) * V(log2_e));
  const V r = (negative(clamped) - n * V(ln2_high)) - n * V(ln2_low);
  V terms(expm1_terms.back());
  for (std::size_t k = expm1_terms.size() - 1; k-- > 0;) terms = terms * r + V(expm1_terms[k]);
  const V p = r + (r * r) * terms;
  const V power = power_of_two(n);
  const auto is_zero = x > V(exp_zero);
  return {select<V>(is_zero, V(0.0), power + power * p), select<V>(is_zero, V(-1.0), power * p + (power - V(1.0)))};
}

template <class V>
struct SinCosLanes {
  V sin, cos;
};

template <class V>
SinCosLanes<V> sincos_near(V r) noexcept {
  const V r2 = r * r;
  V s(sin_terms.back());
  for (std::size_t k = sin_terms.size() - 1; k-- > 0;) s = s * r2 + V(sin_terms[k]);
  V c(cos_terms.back());
  for (std::size_t k = cos_terms.size() - 1; k-- > 0;) c = c * r2 + V(cos_terms[k]);
  const V half = V(0.5) * r2;
  const V head = V(1.0) - half;
  return {r + r * (r2 * s), head + (((V(1.0) - head) - half) + (r2 * r2) * c)};
}

template <class V>
SinCosLanes<V> sincos_lanes(V x) noexcept {
  const V n = rounded(x * V(two_over_pi));
  const V r = ((x - n * V(half_pi_1)) - n * V(half_pi_2)) - n * V(half_pi_3);
  const auto near = sincos_near(r);
  const V quarter = V(0.25) * n;
  const V part = quarter - rounded(quarter);
  const V size = magnitude(part);
  const auto is_quarter = size == V(0.25);
  const V s = select<V>(is_quarter, near.cos, near.sin);
  const V c = select<V>(is_quarter, near.sin, near.cos);
  const auto is_half = size == V(0.5);
  return {select<V>(is_half || part == V(-0.25), negative(s), s), select<V>(is_half || part == V(0.25), negative(c), c)};
}

template <class V>
struct PhiLanes {
  V phi1, phi2;
};

template <class V>
PhiLanes<V> phi_lanes(V x, V expm1) noexcept {
  V series(inverse_factorials[phi_series_terms + 1]);
  for (std::size_t n = phi_series_terms; n >= 2; --n) series = series * x + V(inverse_factorials[n]);
  const auto is_small = magnitude(x) < V(phi_series_limit);
  const V divisor = select<V>(is_small, V(1.0), x);
  const V direct = expm1 / divisor;
  return {select<V>(is_small, V(1.0) + x * series, direct), select<V>(is_small, series, (direct - V(1.0)) / divisor)};
}

template <class V>
struct PsiLanes {
  V psi1, psi2, psi3;
};

template <class V>
PsiLanes<V> psi_taylor(V w, V q) noexcept {
  V d(1.0);
  V next = negative(q);
  V psi1(0.0), psi2(0.0), psi3(0.0);
  for (std::size_t n = 0; n < psi_taylor_terms; ++n) {
    psi1 = psi1 + d * V(inverse_factorials[n + 1]);
    psi2 = psi2 + d * V(inverse_factorials[n + 2]);
    psi3 = psi3 + d * V(inverse_factorials[n + 3]);
    const V after = negative(q * next + w * d);
    d = next;
    next = after;
  }
  return {psi1, psi2, psi3};
}

template <class V>
PsiLanes<V> psi_lanes(V w_any, V q_any) noexcept {
  const V zero(0.0), one(1.0);
  const V w = select<V>(w_any < V(psi_huge), w_any, V(psi_huge));
  const V q = select<V>(q_any < V(psi_huge_root), q_any, V(psi_huge_root));
  const V b = V(0.5) * q;
  const V size = magnitude(b);
  const V root_w = square_root(w);
  const V d = (size - root_w) * (size + root_w);
  const V sg = square_root(select<V>(d > zero, d, zero));
  const V om = square_root(select<V>(d < zero, negative(d), zero));

  const V large = size + sg;
  const V quotient = w / select<V>(large > V(psi_tiny), large, V(psi_tiny));
  const V small = select<V>(quotient < size, quotient, size);
  const auto is_backward = q < zero;
  const V near = select<V>(is_backward, large, negative(small));
  const V far = select<V>(is_backward, small, negative(large));
  const auto exp_near = exp_lanes(negative(near));
  const auto exp_gap = exp_lanes(V(2.0) * sg);
  const auto turn = sincos_lanes(om);
  const V sinc = select<V>(om < V(sinc_series_limit), one - (om * om) * V(1.0 / 6), turn.sin / select<V>(om > zero, om, one));
  const V phi_gap = phi_lanes(V(-2.0) * sg, exp_gap.expm1).phi1;
  const V psi1 = (exp_near.exp * phi_gap) * sinc;
  const V even = (exp_near.exp * (one + V(0.5) * exp_gap.expm1)) * turn.cos;

  const V divisor = select<V>(w > V(psi_tiny), w, V(psi_tiny));
  const V recurrent2 = (one - (even + b * psi1)) / divisor;
  const V recurrent3 = ((one - psi1) - q * recurrent2) / divisor;

  const auto phi_near = phi_lanes(near, exp_near.expm1);
  const auto phi_far = phi_lanes(far, exp_near.exp * (one + exp_gap.expm1) - one);
  const V gap = select<V>(sg > V(psi_tiny), V(2.0) * sg, V(psi_tiny));
  const V divided2 = (phi_near.phi1 - phi_far.phi1) / gap;
  const V divided3 = (phi_near.phi2 - phi_far.phi2) / gap;

  const auto is_apart = d > V(0.25) * (b * b);
  const auto is_tiny = w <= V(psi_taylor_limit) && V(2.0) * size <= V(psi_taylor_limit);
  const auto series = psi_taylor(w, q);
  return {select<V>(is_tiny, series.psi1, psi1), select<V>(is_tiny, series.psi2, select<V>(is_apart, divided2, recurrent2)),
          select<V>(is_tiny, series.psi3, select<V>(is_apart, divided3, recurrent3))};
}

template <class V>
void rate(const RateRun& run) noexcept {
  const V h(run.h);
  for (std::size_t i = 0; i < run.count; i += V::size) {
    const V W = load_lanes<V>(run.W + i);
    const V w = (W * h) * h;
    const V gh = load_lanes<V>(run.g + i) * h;
    const V q = select<V>(gh < V(psi_huge_root), gh, V(psi_huge_root));
    const auto at = psi_lanes(w, q);
    store_lanes(run.A + i, (W * h) * at.psi1);
    store_lanes(run.B + i, q * at.psi1 + w * at.psi2);
    store_lanes(run.C + i, w * at.psi2);
    store_lanes(run.S + i, h * at.psi1);
    store_lanes(run.X + i, (h * h) * at.psi2);
  }
}

template <class V>
void rate_sinusoid(const RateSinusoid& run) noexcept {
  const V h(run.h);
  const V theta(run.theta);
  for (std::size_t i = 0; i < run.count; i += V::size) {
    const V w = (load_lanes<V>(run.W + i) * h) * h;
    const V q = load_lanes<V>(run.g + i) * h;
    V d(1.0);
    V next = negative(q);
    V re(1.0), im(0.0);
    V v_re(0.0), v_im(0.0), x_re(0.0), x_im(0.0);
    for (std::size_t m = 0; m < psi_taylor_terms; ++m) {
      v_re = v_re + re * V(inverse_factorials[m + 1]);
      v_im = v_im + im * V(inverse_factorials[m + 1]);
      x_re = x_re + re * V(inverse_factorials[m + 2]);
      x_im = x_im + im * V(inverse_factorials[m + 2]);
      const V turned = next - theta * im;
      im = theta * re;
      re = turned;
      const V after = negative(q * next + w * d);
      d = next;
      next = after;
    }
    store_lanes(run.in_v + i, h * v_re);
    store_lanes(run.quad_v + i, h * v_im);
    store_lanes(run.in_x + i, (h * h) * x_re);
    store_lanes(run.quad_x + i, (h * h) * x_im);
  }
}

}  // namespace
}  // namespace dvdx
