// Threes of consecutive numbers, at any stride: conversion to records and back.
#pragma once

#include <cstddef>
#include <type_traits>

#include "simd/records.hpp"

namespace dvdx {
namespace {

// Without optimisation, g++'s gathers and shifts are macros, and it warns of their full masks.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-conversion"

// The three numbers at p and a zero, and back. Nothing beside these three is read or written.
#if defined(__SSE2__)
#if defined(__AVX512F__)
inline __m128 load_three(const float* p) noexcept { return _mm_maskz_loadu_ps(__mmask8{7}, p); }
inline void store_three(float* p, __m128 three) noexcept { _mm_mask_storeu_ps(p, __mmask8{7}, three); }
inline __m256d load_three(const double* p) noexcept { return _mm256_maskz_loadu_pd(__mmask8{7}, p); }
inline void store_three(double* p, __m256d three) noexcept { _mm256_mask_storeu_pd(p, __mmask8{7}, three); }
#else
#if defined(__AVX2__)
inline __m128 load_three(const float* p) noexcept { return _mm_maskload_ps(p, _mm_setr_epi32(-1, -1, -1, 0)); }
inline __m256d load_three(const double* p) noexcept { return _mm256_maskload_pd(p, _mm256_setr_epi64x(-1, -1, -1, 0)); }
inline void store_three(double* p, __m256d three) noexcept {  // masked stores take 18 operations on some machines
  _mm_storeu_si128(reinterpret_cast<__m128i_u*>(p), _mm256_castsi256_si128(_mm256_castpd_si256(three)));
  _mm_storel_epi64(reinterpret_cast<__m128i_u*>(p + 2), _mm256_extracti128_si256(_mm256_castpd_si256(three), 1));
}
#else
inline __m128 load_three(const float* p) noexcept {
  const __m128i two = _mm_loadl_epi64(reinterpret_cast<const __m128i_u*>(p));
  return _mm_movelh_ps(_mm_castsi128_ps(two), _mm_load_ss(p + 2));
}
#endif
inline void store_three(float* p, __m128 three) noexcept {
  _mm_storel_epi64(reinterpret_cast<__m128i_u*>(p), _mm_castps_si128(three));
  _mm_store_ss(p + 2, _mm_movehl_ps(three, three));
}
#endif
#elif defined(__aarch64__)
inline float32x4_t load_three(const float* p) noexcept {
  return vcombine_f32(vld1_f32(p), vset_lane_f32(p[2], vdup_n_f32(0), 0));
}
inline void store_three(float* p, float32x4_t three) noexcept {
  vst1_f32(p, vget_low_f32(three));
  vst1q_lane_f32(p + 2, three, 2);
}
#endif

// The element k strides behind p.
template <class T>
[[gnu::always_inline]] inline T* strided(T* p, std::ptrdiff_t stride, std::size_t k) noexcept {
  using Byte = std::conditional_t<std::is_const_v<T>, const std::byte, std::byte>;
  return reinterpret_cast<T*>(reinterpret_cast<Byte*>(p) + static_cast<std::ptrdiff_t>(k) * stride);
}

// As many records as a register has lanes, from the threes at p, p + stride, and so on, placed as by gather_records.
template <class V>
[[gnu::always_inline]] inline Records<V> load_threes(const Scalar<V>* p, std::ptrdiff_t stride) noexcept {
  [[maybe_unused]] const auto three = [&](auto k) { return load_three(strided(p, stride, k)); };
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    const auto from = [&](std::size_t k) {
      const __m512 two = _mm512_insertf32x4(_mm512_castps128_ps512(three(k)), three(k + 4), 1);
      return V(_mm512_insertf32x4(_mm512_insertf32x4(two, three(k + 8), 2), three(k + 12), 3));
    };
    return {{from(0), from(1), from(2), from(3)}};
  } else if constexpr (sizeof(V) == 64) {
    const auto from = [&](std::size_t k) { return V(_mm512_insertf64x4(_mm512_castpd256_pd512(three(k)), three(k + 2), 1)); };
    return {{from(0), from(1), from(4), from(5)}};
  }
#elif defined(__AVX2__)
  if constexpr (sizeof(V) == 32 && sizeof(Scalar<V>) == 4) {
    const auto from = [&](std::size_t k) { return V(_mm256_insertf128_ps(_mm256_castps128_ps256(three(k)), three(k + 4), 1)); };
    return {{from(0), from(1), from(2), from(3)}};
  } else if constexpr (sizeof(V) == 32) {
    return {{V(three(0)), V(three(1)), V(three(2)), V(three(3))}};
  }
#else
  if constexpr (sizeof(Scalar<V>) == 4) {
    return {{V(three(0)), V(three(1)), V(three(2)), V(three(3))}};
  } else {
    const Scalar<V>* const q = strided(p, stride, 1);
    const V zero(Scalar<V>(0));
    return {{load_lanes<V>(p), unpack_low(V(p[2]), zero), load_lanes<V>(q), unpack_low(V(q[2]), zero)}};
  }
#endif
}
template <class V>
[[gnu::always_inline]] inline void store_threes(Scalar<V>* p, std::ptrdiff_t stride, const Records<V>& records) noexcept {
  const auto at = [&](std::size_t k) { return strided(p, stride, k); };
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    for (std::size_t k = 0; k < 4; ++k) {
      store_three(at(k), _mm512_castps512_ps128(records.at[k]));
      store_three(at(k + 4), _mm512_extractf32x4_ps(records.at[k], 1));
      store_three(at(k + 8), _mm512_extractf32x4_ps(records.at[k], 2));
      store_three(at(k + 12), _mm512_extractf32x4_ps(records.at[k], 3));
    }
  } else if constexpr (sizeof(V) == 64) {
    constexpr std::size_t firsts[4] = {0, 1, 4, 5};
    for (std::size_t n = 0; n < 4; ++n) {
      store_three(at(firsts[n]), _mm512_castpd512_pd256(records.at[n]));
      store_three(at(firsts[n] + 2), _mm512_extractf64x4_pd(records.at[n], 1));
    }
  }
#elif defined(__AVX2__)
  if constexpr (sizeof(V) == 32 && sizeof(Scalar<V>) == 4) {
    for (std::size_t k = 0; k < 4; ++k) {
      store_three(at(k), _mm256_castps256_ps128(records.at[k]));
      store_three(at(k + 4), _mm256_extractf128_ps(records.at[k], 1));
    }
  } else if constexpr (sizeof(V) == 32) {
    for (std::size_t k = 0; k < 4; ++k) store_three(at(k), records.at[k]);
  }
#else
  if constexpr (sizeof(Scalar<V>) == 4) {
    for (std::size_t k = 0; k < 4; ++k) store_three(at(k), records.at[k]);
  } else {
    for (std::size_t k = 0; k < 2; ++k) {
      store_lanes(at(k), records.at[2 * k]);
      at(k)[2] = records.at[2 * k + 1].get(0);
    }
  }
#endif
}

// Whether a register takes what needs two of 8 floats: two particles' threes at p and 16 bytes behind, or a row of two tiles.
template <class V>
inline constexpr bool holds_pairs = sizeof(V) == 64 && sizeof(Scalar<V>) == 4;

// 8 numbers at each of two places, and back.
template <class V>
[[gnu::always_inline]] inline V load_two(const Scalar<V>* p, [[maybe_unused]] const Scalar<V>* q) noexcept {
#if defined(__AVX512F__)
  return V(_mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps(p)), _mm256_loadu_ps(q), 1));
#else
  return load_lanes<V>(p);
#endif
}
template <class V>
[[gnu::always_inline]] inline void store_two(Scalar<V>* p, [[maybe_unused]] Scalar<V>* q, V value) noexcept {
#if defined(__AVX512F__)
  _mm256_storeu_ps(p, _mm512_castps512_ps256(value));
  _mm256_storeu_ps(q, _mm512_extractf32x8_ps(value, 1));
#else
  store_lanes(p, value);
#endif
}

template <class V>
struct RecordPairs {
  Records<V> first, second;
};
template <class V>
[[gnu::always_inline]] inline RecordPairs<V> load_pairs([[maybe_unused]] const Scalar<V>* p,
                                                        [[maybe_unused]] std::ptrdiff_t stride) noexcept {
  RecordPairs<V> pairs;
#if defined(__AVX512F__)
  if constexpr (holds_pairs<V>) {
    const auto pair = [&](std::size_t k) { return _mm256_maskz_loadu_ps(__mmask8{0x77}, strided(p, stride, k)); };
    const auto two = [&](std::size_t k) { return _mm512_insertf32x8(_mm512_castps256_ps512(pair(k)), pair(k + 4), 1); };
    for (std::size_t k = 0; k < 4; ++k) {
      const __m512 low = two(k), high = two(k + 8);
      pairs.first.at[k] = V(_mm512_shuffle_f32x4(low, high, 0b10001000));
      pairs.second.at[k] = V(_mm512_shuffle_f32x4(low, high, 0b11011101));
    }
  }
#endif
  return pairs;
}
template <class V>
[[gnu::always_inline]] inline void store_pairs([[maybe_unused]] Scalar<V>* p, [[maybe_unused]] std::ptrdiff_t stride,
                                               [[maybe_unused]] const RecordPairs<V>& pairs) noexcept {
#if defined(__AVX512F__)
  if constexpr (holds_pairs<V>) {
    const __m512i low = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
    const __m512i high = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
    const auto store = [&](std::size_t k, __m512d two) {
      const __m512 numbers = _mm512_castpd_ps(two);
      _mm256_mask_storeu_ps(strided(p, stride, k), __mmask8{0x77}, _mm512_castps512_ps256(numbers));
      _mm256_mask_storeu_ps(strided(p, stride, k + 4), __mmask8{0x77}, _mm512_extractf32x8_ps(numbers, 1));
    };
    for (std::size_t k = 0; k < 4; ++k) {
      const __m512d first = _mm512_castps_pd(pairs.first.at[k]), second = _mm512_castps_pd(pairs.second.at[k]);
      store(k, _mm512_permutex2var_pd(first, low, second));
      store(k + 8, _mm512_permutex2var_pd(first, high, second));
    }
  }
#endif
}

#pragma GCC diagnostic pop

}  // namespace
}  // namespace dvdx
