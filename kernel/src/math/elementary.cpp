#include "math/elementary.hpp"

#include <cmath>
#include <cstddef>

// exp(-x) = 2^n exp(r)      n = round(-x / ln 2),  r = -x - n ln 2,  |r| <= ln(2)/2
//   r is formed with ln 2 in two parts. n times the first is exact, so its absolute error, which is the relative error
//   of exp, stays below 2^-55. exp(r) - 1 is Taylor's series: its remainder r^15/15! is 1e-19 of r. 2^n is a product of exact
//   powers of two chosen bit by bit, which needs neither integers nor the layout of a double.
// sin x, cos x:             n = round(x 2/pi),  r = x - n pi/2,  |r| <= pi/4, then by the quadrant n mod 4
//   (Cody and Waite, Software Manual for the Elementary Functions, 1980.) 33-bit parts make n half_pi_1 and n half_pi_2 exact
//   for |n| <= 2^20; what the third leaves out is 2^20 2^-122. Farther out pi/2 has 160 bits and the products are exact sums.

namespace dvdx {
namespace {

double rounded(double x) noexcept { return (x + round_magic) - round_magic; }

// 2^n for integers |n| <= 1023.
double power_of_two(double n) noexcept {
  double rest = n < 0 ? -n : n;
  double power = 1;
  double up = 0x1p+512;
  double down = 0x1p-512;
  for (double bit = 512; bit >= 1; bit *= 0.5) {
    const bool has = rest >= bit;
    power = power * (has ? (n < 0 ? down : up) : 1.0);
    rest = rest - (has ? bit : 0.0);
    up = std::sqrt(up);
    down = std::sqrt(down);
  }
  return power;
}

// sin and cos of |r| <= pi/4.
SinCos sincos_near(double r) noexcept {
  const double r2 = r * r;
  double s = sin_terms.back();
  for (std::size_t k = sin_terms.size() - 1; k-- > 0;) s = s * r2 + sin_terms[k];
  double c = cos_terms.back();
  for (std::size_t k = cos_terms.size() - 1; k-- > 0;) c = c * r2 + cos_terms[k];
  // The small terms bring back what 1 - r^2/2 loses in rounding.
  const double half = 0.5 * r2;
  const double head = 1.0 - half;
  return {r + r * (r2 * s), head + (((1.0 - head) - half) + (r2 * r2) * c)};
}

// Turns sin r, cos r by n quarters.
SinCos turned(SinCos near, double n) noexcept {
  const double quarter = 0.25 * n;
  const double part = quarter - rounded(quarter);  // -1/2, -1/4, 0, 1/4, 1/2
  const double size = part < 0 ? -part : part;
  const double s = size == 0.25 ? near.cos : near.sin;
  const double c = size == 0.25 ? near.sin : near.cos;
  const bool sin_negative = size == 0.5 || part == -0.25;
  const bool cos_negative = size == 0.5 || part == 0.25;
  return {sin_negative ? -s : s, cos_negative ? -c : c};
}

struct Reduced {
  TwoDouble r;
  double quarters;  // mod 4
};

// Each round takes 50 bits off x; from 1e16 on, the doubles themselves no longer know their quadrant.
Reduced reduced(TwoDouble x) noexcept {
  Reduced result{x, 0};
  for (int round = 0; round < 24; ++round) {
    const double n = std::nearbyint(result.r.high * two_over_pi);
    if (n == 0) break;
    for (const double part : half_pi) result.r = result.r - two_product(n, part);
    result.quarters = std::remainder(result.quarters + std::remainder(n, 4.0), 4.0);
  }
  return result;
}

}  // namespace

ExpNegative exp_pair_negative(double x) noexcept {
  const double low = x < -exp_zero ? -exp_zero : x;
  const double clamped = low > exp_zero ? exp_zero : low;
  const double n = rounded(-clamped * log2_e);
  const double r = (-clamped - n * ln2_high) - n * ln2_low;
  double terms = expm1_terms.back();
  for (std::size_t k = expm1_terms.size() - 1; k-- > 0;) terms = terms * r + expm1_terms[k];
  const double p = r + (r * r) * terms;
  const double power = power_of_two(n);
  const bool zero = x > exp_zero;
  return {zero ? 0.0 : power + power * p, zero ? -1.0 : power * p + (power - 1.0)};
}

double exp_negative(double x) noexcept { return exp_pair_negative(x).exp; }

double expm1_negative(double x) noexcept { return exp_pair_negative(x).expm1; }

SinCos sincos(double x) noexcept {
  if (!(x >= -sincos_fast && x <= sincos_fast)) return sincos(TwoDouble(x));
  const double n = rounded(x * two_over_pi);
  const double r = ((x - n * half_pi_1) - n * half_pi_2) - n * half_pi_3;
  return turned(sincos_near(r), n);
}

SinCos sincos(TwoDouble x) noexcept {
  const Reduced at = reduced(x);
  const SinCos near = sincos_near(at.r.high);
  const SinCos nudged{near.sin + near.cos * at.r.low, near.cos - near.sin * at.r.low};
  return turned(nudged, at.quarters);
}

}  // namespace dvdx
