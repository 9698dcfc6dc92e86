// The functions psi_k(w, q) of a damped oscillator: everything that a step of a linear force needs.
#pragma once

#include <array>
#include <cstddef>

//   psi_k(w,q) = sum_{n>=0} d_n / (n+k)!,   d_0 = 1, d_1 = -q, d_{n+2} = -q d_{n+1} - w d_n
//   psi_{k-1} + q psi_k + w psi_{k+1} = 1/(k-1)!   (k >= 1)
// w = W h^2 >= 0; q = g h is negative where time runs backwards.

namespace dvdx {

struct Psi {
  double psi0, psi1, psi2, psi3;
};

// The double-precision form for per-particle coefficients: straight-line code of + - * / sqrt, compares and selects around
// exp_negative and sincos. A wide body repeats it operation by operation. Finite for w >= 0 and q >= -600. 1 - psi0 is more
// precise as q psi1 + w psi2.
Psi psi(double w, double q) noexcept;

// psi_k for k = 0 .. psi_max by doubling in two doubles (two_double_flow.hpp), correctly rounded but for its last bit.
inline constexpr int psi_max = 9;
double psi_k(int k, double w, double q) noexcept;

// Constants of psi() for its wide twin.
inline constexpr double psi_taylor_limit = 2.0;       // the series serves max(w, |q|) <= this
inline constexpr int psi_taylor_terms = 24;           // d_0 .. d_23
inline constexpr double phi_series_limit = 1.0;       // the series of phi_1 and phi_2 serves |x| < this
inline constexpr int phi_series_terms = 18;           // 1/2! .. 1/19!
inline constexpr double sinc_series_limit = 0x1p-13;  // below: sinc x = 1 - x^2/6
inline constexpr double psi_tiny = 0x1p-1000;         // keeps divisors away from 0
inline constexpr double psi_huge = 0x1p+900;          // w is cut off here: its sine has long lost all meaning,
inline constexpr double psi_huge_root = 0x1p+450;     // and |q| here, so that its square is finite

inline constexpr std::array<double, 28> inverse_factorials = [] {
  std::array<double, 28> table{1.0};
  double factorial = 1;
  for (std::size_t n = 1; n < table.size(); ++n) table[n] = 1.0 / (factorial *= static_cast<double>(n));
  return table;
}();

}  // namespace dvdx
