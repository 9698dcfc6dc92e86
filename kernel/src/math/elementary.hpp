// exp, sin and cos from + - * / alone, so that coefficients have the same bits with every compiler and every math library.
#pragma once

#include <array>

#include "math/two_double.hpp"

// exp_negative, expm1_negative and sincos (within its fast range) are straight-line code of + - *, compares and selects in a
// fixed order. A wide body repeats it operation by operation with the constants below, and has the same bits in every lane.

namespace dvdx {

struct SinCos {
  double sin, cos;
};

// exp(-x) for any x; 0 for x > exp_zero, so that no denormal appears; for x < -exp_zero the value at -exp_zero.
double exp_negative(double x) noexcept;

// exp(-x) - 1 with full relative precision at small x. The range as above.
double expm1_negative(double x) noexcept;

// Both of them, from one polynomial.
struct ExpNegative {
  double exp, expm1;
};
ExpNegative exp_pair_negative(double x) noexcept;

// Within 2 ulp (relative to 1 where a value is near its zero) for |x| <= sincos_fast; beyond, x is reduced in two doubles.
SinCos sincos(double x) noexcept;
SinCos sincos(TwoDouble x) noexcept;

inline constexpr double exp_zero = 700.0;
inline constexpr double log2_e = 0x1.71547652b82fep+0;
// ln 2 in two parts; n * ln2_high is exact for |n| < 2^20.
inline constexpr double ln2_high = 0x1.62e42feep-1;
inline constexpr double ln2_low = 0x1.a39ef35793c76p-33;
// Adding and subtracting 1.5 * 2^52 rounds to the nearest integer, ties to even.
inline constexpr double round_magic = 0x1.8p+52;
// expm1(r) = r + r^2 (1/2! + r/3! + ... + r^12/14!), by Horner's rule, for |r| <= ln(2)/2.
inline constexpr std::array<double, 13> expm1_terms = {
    1.0 / 2,      1.0 / 6,       1.0 / 24,       1.0 / 120,       1.0 / 720,        1.0 / 5040,       1.0 / 40320,
    1.0 / 362880, 1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800, 1.0 / 87178291200};

// pi/2 in three parts of 33 bits: n * half_pi_1 and n * half_pi_2 are exact for |n| <= 2^20.
inline constexpr double sincos_fast = 1647099.0;  // 2^20 pi/2
inline constexpr double two_over_pi = 0x1.45f306dc9c883p-1;
// pi/2 as the sum of three full doubles, for arguments beyond.
inline constexpr std::array<double, 3> half_pi = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54, -0x1.f1976b7ed8fbcp-110};
inline constexpr double half_pi_1 = 0x1.921fb544p+0;
inline constexpr double half_pi_2 = 0x1.0b4611a6p-34;
inline constexpr double half_pi_3 = 0x1.3198a2e037073p-69;
// sin r = r + r^3 (s0 + s1 r^2 + ...), cos r = 1 - r^2/2 + r^4 (c0 + c1 r^2 + ...): Taylor's series on |r| <= pi/4.
inline constexpr std::array<double, 8> sin_terms = {-1.0 / 6,
                                                    1.0 / 120,
                                                    -1.0 / 5040,
                                                    1.0 / 362880,
                                                    -1.0 / 39916800,
                                                    1.0 / 6227020800,
                                                    -1.0 / 1307674368000.0,
                                                    1.0 / 355687428096000.0};
inline constexpr std::array<double, 7> cos_terms = {
    1.0 / 24, -1.0 / 720, 1.0 / 40320, -1.0 / 3628800, 1.0 / 479001600, -1.0 / 87178291200.0, 1.0 / 20922789888000.0};

}  // namespace dvdx
