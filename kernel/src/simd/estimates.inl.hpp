// 1/sqrt(x) from the machine's own estimate, for fast arithmetic. The bits differ from machine to machine, because makers are
// free in how they estimate. The bound of the error does not:
//
//   y = (1 + delta) / sqrt(x)     e = 1 - x y^2     1/sqrt(x) = y (1 - e)^(-1/2) = y + y e (1/2 + 3/8 e + 5/16 e^2 + ...)
//
// |e| <= 2 |delta| + delta^2. One term is Newton's step. As many terms are taken as leave at most a tenth of a rounding u,
// which is 2^-24 or 2^-53:
//
//   | estimate          | delta     | e      | terms | left by the next term |
//   | AVX-512, float32  | 2^-14     | 1.2e-4 | 1     | 0.09 u                |
//   | AVX-512, float64  | 2^-14     | 1.2e-4 | 4     | 1e-4 u                |
//   | AVX2, float32     | 1.5 2^-12 | 7.3e-4 | 2     | 2e-3 u                |
//   | neon64, float32   | 2^-8      | 7.8e-3 | 3     | 0.02 u                |
//   | neon64, float64   | 2^-8      | 7.8e-3 | 7     | 0.03 u                |
//
// x y is rounded before x y^2 is taken from 1, which leaves up to u in e, and half of it in the root. With the last rounding
// the result is within 1.2 units in the last place; the bit trick's (network.hpp) is within 1.01. AVX2 has no estimate in
// float64: fast arithmetic there is contracted arithmetic.
#pragma once

#include <array>
#include <cstddef>

#include "simd/lanes.hpp"

namespace dvdx {
namespace {

// Terms of the series that the estimate needs; 0: there is no estimate.
struct EstimateTerms {
  std::size_t of_float, of_double;
};
#if defined(__AVX512F__)
constexpr EstimateTerms estimate_terms{.of_float = 1, .of_double = 4};
#elif defined(__AVX2__)
constexpr EstimateTerms estimate_terms{.of_float = 2, .of_double = 0};
#elif defined(__aarch64__)
constexpr EstimateTerms estimate_terms{.of_float = 3, .of_double = 7};
#else
constexpr EstimateTerms estimate_terms{.of_float = 0, .of_double = 0};
#endif
template <class T>
constexpr std::size_t terms_of_estimate = sizeof(T) == 4 ? estimate_terms.of_float : estimate_terms.of_double;

template <class V>
[[gnu::always_inline]] inline V estimated_inverse_root(V x) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(Scalar<V>) == 4) return V(_mm512_maskz_rsqrt14_ps(__mmask16{0xffff}, x));
  if constexpr (sizeof(Scalar<V>) == 8) return V(_mm512_maskz_rsqrt14_pd(__mmask8{0xff}, x));
#elif defined(__AVX2__)
  return V(_mm256_rsqrt_ps(x));
#elif defined(__aarch64__)
  if constexpr (sizeof(Scalar<V>) == 4) return V(vrsqrteq_f32(x));
  if constexpr (sizeof(Scalar<V>) == 8) return V(vrsqrteq_f64(x));
#else
  return x;  // there is no estimate, and nothing asks for one
#endif
}

// The result is arbitrary if x is 0, infinite or NaN, as for any root by steps from a guess.
template <class V>
[[gnu::always_inline]] inline V inverse_root_by_estimate(V x) noexcept {
  using T = Scalar<V>;
  constexpr std::array<T, 7> series = {T(0.5),        T(0.375),        T(0.3125),       T(0.2734375),
                                       T(0.24609375), T(0.2255859375), T(0.20947265625)};
  constexpr std::size_t terms = terms_of_estimate<T>;
  const V y = estimated_inverse_root(x);
  const V e = fused_negative_multiply_add(x * y, y, V(T(1)));
  V sum(series[terms - 1]);
  for (std::size_t n = terms - 1; n-- > 0;) sum = fused_multiply_add(sum, e, V(series[n]));
  if constexpr (terms == 1) return fused_multiply_add(y * sum, e, y);  // the product does not wait for e
  return fused_multiply_add(y * e, sum, y);
}

}  // namespace
}  // namespace dvdx
