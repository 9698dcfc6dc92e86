// Records of four consecutive numbers, as many as a register has lanes: conversion to lanes and back.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "simd/registers.hpp"

namespace dvdx {
namespace {

// Without optimisation, g++'s gathers and shifts are macros, and it warns of their full masks.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-conversion"

// As many records as a register has lanes, in four registers. Each instruction set chooses which register holds which records,
// so that the transposes between records and lanes take least.
template <class V>
struct Records {
  V at[4];
};

// Interleaves the first, or the last, halves of a and b in each 128 bits. (xsimd's zips do this on x86 up to version 8.1.)
template <class V>
[[gnu::always_inline]] inline V unpack_low(V a, V b) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    return V(_mm512_unpacklo_ps(a, b));
  } else if constexpr (sizeof(V) == 64) {
    return V(_mm512_unpacklo_pd(a, b));
  }
#endif
#if defined(__AVX2__)
  if constexpr (sizeof(V) == 32 && sizeof(Scalar<V>) == 4) {
    return V(_mm256_unpacklo_ps(a, b));
  } else if constexpr (sizeof(V) == 32) {
    return V(_mm256_unpacklo_pd(a, b));
  }
#endif
  if constexpr (sizeof(V) == 16) return xsimd::zip_lo(a, b);
}
template <class V>
[[gnu::always_inline]] inline V unpack_high(V a, V b) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    return V(_mm512_unpackhi_ps(a, b));
  } else if constexpr (sizeof(V) == 64) {
    return V(_mm512_unpackhi_pd(a, b));
  }
#endif
#if defined(__AVX2__)
  if constexpr (sizeof(V) == 32 && sizeof(Scalar<V>) == 4) {
    return V(_mm256_unpackhi_ps(a, b));
  } else if constexpr (sizeof(V) == 32) {
    return V(_mm256_unpackhi_pd(a, b));
  }
#endif
  if constexpr (sizeof(V) == 16) return xsimd::zip_hi(a, b);
}

// The record of lane k is at base + index[k].
template <class V>
[[gnu::always_inline]] inline Records<V> gather_records(const Scalar<V>* base, const std::uint32_t* index) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {  // every fourth in a register
    const auto from = [&](std::size_t k) {
      __m512 four = _mm512_castps128_ps512(_mm_loadu_ps(base + index[k]));
      four = _mm512_insertf32x4(four, _mm_loadu_ps(base + index[k + 4]), 1);
      four = _mm512_insertf32x4(four, _mm_loadu_ps(base + index[k + 8]), 2);
      return V(_mm512_insertf32x4(four, _mm_loadu_ps(base + index[k + 12]), 3));
    };
    return {{from(0), from(1), from(2), from(3)}};
  } else if constexpr (sizeof(V) == 64) {  // 0 and 2, 1 and 3, 4 and 6, 5 and 7
    const auto from = [&](std::size_t k) {
      const __m512d first = _mm512_castpd256_pd512(_mm256_loadu_pd(base + index[k]));
      return V(_mm512_insertf64x4(first, _mm256_loadu_pd(base + index[k + 2]), 1));
    };
    return {{from(0), from(1), from(4), from(5)}};
  }
#endif
#if defined(__AVX2__)
  if constexpr (sizeof(V) == 32 && sizeof(Scalar<V>) == 4) {  // every fourth
    const auto from = [&](std::size_t k) {
      const __m256 first = _mm256_castps128_ps256(_mm_loadu_ps(base + index[k]));
      return V(_mm256_insertf128_ps(first, _mm_loadu_ps(base + index[k + 4]), 1));
    };
    return {{from(0), from(1), from(2), from(3)}};
  }
#endif
  if constexpr (V::size <= 4) {  // in order, one or two registers each
    constexpr std::size_t parts = 4 / V::size;
    const auto from = [&](std::size_t n) { return load_lanes<V>(base + index[n / parts] + n % parts * V::size); };
    return {{from(0), from(1), from(2), from(3)}};
  }
}
template <class V>
[[gnu::always_inline]] inline void scatter_records(Scalar<V>* base, const std::uint32_t* index,
                                                   const Records<V>& records) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    for (std::size_t k = 0; k < 4; ++k) {
      _mm_storeu_ps(base + index[k], _mm512_castps512_ps128(records.at[k]));
      _mm_storeu_ps(base + index[k + 4], _mm512_extractf32x4_ps(records.at[k], 1));
      _mm_storeu_ps(base + index[k + 8], _mm512_extractf32x4_ps(records.at[k], 2));
      _mm_storeu_ps(base + index[k + 12], _mm512_extractf32x4_ps(records.at[k], 3));
    }
  } else if constexpr (sizeof(V) == 64) {
    constexpr std::size_t firsts[4] = {0, 1, 4, 5};
    for (std::size_t n = 0; n < 4; ++n) {
      _mm256_storeu_pd(base + index[firsts[n]], _mm512_castpd512_pd256(records.at[n]));
      _mm256_storeu_pd(base + index[firsts[n] + 2], _mm512_extractf64x4_pd(records.at[n], 1));
    }
  }
#endif
#if defined(__AVX2__)
  if constexpr (sizeof(V) == 32 && sizeof(Scalar<V>) == 4) {
    for (std::size_t k = 0; k < 4; ++k) {
      _mm_storeu_ps(base + index[k], _mm256_castps256_ps128(records.at[k]));
      _mm_storeu_ps(base + index[k + 4], _mm256_extractf128_ps(records.at[k], 1));
    }
  }
#endif
  if constexpr (V::size <= 4) {
    constexpr std::size_t parts = 4 / V::size;
    for (std::size_t n = 0; n < 4; ++n) store_lanes(base + index[n / parts] + n % parts * V::size, records.at[n]);
  }
}

// Whether a register holds every fourth of 16 or of 8 records.
template <class V>
inline constexpr bool holds_every_fourth = sizeof(Scalar<V>) == 4 && V::size >= 8;

// The records of two ends. The records of register k alternate from base + index[k] on: a first one, a second one, and so on.
template <class V>
[[gnu::always_inline]] inline void load_in_turn(const Scalar<V>* base, const std::uint32_t* index,
                                                [[maybe_unused]] Records<V>& firsts,
                                                [[maybe_unused]] Records<V>& seconds) noexcept {
  for (std::size_t k = 0; k < 4; ++k) {
    const V low = load_lanes<V>(base + index[k]), high = load_lanes<V>(base + index[k] + V::size);
#if defined(__AVX512F__)
    if constexpr (sizeof(V) == 64) {
      firsts.at[k] = V(_mm512_shuffle_f32x4(low, high, 0b10001000));
      seconds.at[k] = V(_mm512_shuffle_f32x4(low, high, 0b11011101));
    }
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(V) == 32) {
      firsts.at[k] = V(_mm256_permute2f128_ps(low, high, 0x20));
      seconds.at[k] = V(_mm256_permute2f128_ps(low, high, 0x31));
    }
#endif
  }
}
template <class V>
[[gnu::always_inline]] inline void store_in_turn([[maybe_unused]] Scalar<V>* base, [[maybe_unused]] const std::uint32_t* index,
                                                 const Records<V>& firsts, const Records<V>& seconds) noexcept {
  for (std::size_t k = 0; k < 4; ++k) {
    const V a = firsts.at[k], b = seconds.at[k];
#if defined(__AVX512F__)
    if constexpr (sizeof(V) == 64) {
      const __m512i low = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
      const __m512i high = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
      const __m512d firsts_of = _mm512_castps_pd(a), seconds_of = _mm512_castps_pd(b);
      store_lanes(base + index[k], V(_mm512_castpd_ps(_mm512_permutex2var_pd(firsts_of, low, seconds_of))));
      store_lanes(base + index[k] + V::size, V(_mm512_castpd_ps(_mm512_permutex2var_pd(firsts_of, high, seconds_of))));
    }
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(V) == 32) {
      store_lanes(base + index[k], V(_mm256_permute2f128_ps(a, b, 0x20)));
      store_lanes(base + index[k] + V::size, V(_mm256_permute2f128_ps(a, b, 0x31)));
    }
#endif
  }
}
// The records of register k stand side by side from base + index[k] on.
template <class V>
[[gnu::always_inline]] inline Records<V> load_side_by_side(const Scalar<V>* base, const std::uint32_t* index) noexcept {
  return {{load_lanes<V>(base + index[0]), load_lanes<V>(base + index[1]), load_lanes<V>(base + index[2]),
           load_lanes<V>(base + index[3])}};
}
template <class V>
[[gnu::always_inline]] inline void store_side_by_side(Scalar<V>* base, const std::uint32_t* index,
                                                      const Records<V>& records) noexcept {
  for (std::size_t k = 0; k < 4; ++k) store_lanes(base + index[k], records.at[k]);
}

// The first, second, third and fourth numbers of all records.
template <class V>
[[gnu::always_inline]] inline std::array<V, 4> columns_of(const Records<V>& records) noexcept {
  const V a = records.at[0], b = records.at[1], c = records.at[2], d = records.at[3];
  if constexpr (sizeof(Scalar<V>) == 4) {
    const V ac = unpack_low(a, c), bd = unpack_low(b, d), ac2 = unpack_high(a, c), bd2 = unpack_high(b, d);
    return {unpack_low(ac, bd), unpack_high(ac, bd), unpack_low(ac2, bd2), unpack_high(ac2, bd2)};
  } else if constexpr (sizeof(V) == 16) {
    return {unpack_low(a, c), unpack_high(a, c), unpack_low(b, d), unpack_high(b, d)};
  } else {
    const V ab = unpack_low(a, b), cd = unpack_low(c, d), ab2 = unpack_high(a, b), cd2 = unpack_high(c, d);
#if defined(__AVX512F__)
    if constexpr (sizeof(V) == 64) {
      return {V(_mm512_shuffle_f64x2(ab, cd, 0b10001000)), V(_mm512_shuffle_f64x2(ab2, cd2, 0b10001000)),
              V(_mm512_shuffle_f64x2(ab, cd, 0b11011101)), V(_mm512_shuffle_f64x2(ab2, cd2, 0b11011101))};
    }
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(V) == 32) {
      return {V(_mm256_permute2f128_pd(ab, cd, 0x20)), V(_mm256_permute2f128_pd(ab2, cd2, 0x20)),
              V(_mm256_permute2f128_pd(ab, cd, 0x31)), V(_mm256_permute2f128_pd(ab2, cd2, 0x31))};
    }
#endif
  }
}
template <class V>
[[gnu::always_inline]] inline Records<V> records_of(const std::array<V, 4>& columns) noexcept {
  const auto [x, y, z, w] = columns;
  if constexpr (sizeof(V) == 16 && sizeof(Scalar<V>) == 8) {
    return {{unpack_low(x, y), unpack_low(z, w), unpack_high(x, y), unpack_high(z, w)}};
  }
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 8) {
    const V xy = unpack_low(x, y), zw = unpack_low(z, w), xy2 = unpack_high(x, y), zw2 = unpack_high(z, w);
    const __m512i first = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
    const __m512i last = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
    return {{V(_mm512_permutex2var_pd(xy, first, zw)), V(_mm512_permutex2var_pd(xy2, first, zw2)),
             V(_mm512_permutex2var_pd(xy, last, zw)), V(_mm512_permutex2var_pd(xy2, last, zw2))}};
  }
#endif
  const auto [a, b, c, d] = columns_of(Records<V>{{x, y, z, w}});  // a 4 x 4 transpose is its own inverse
  return {{a, b, c, d}};
}
// Each lane four times, in its record's place.
template <class V>
[[gnu::always_inline]] inline Records<V> records_of(V each) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    return {{V(_mm512_permute_ps(each, 0x00)), V(_mm512_permute_ps(each, 0x55)), V(_mm512_permute_ps(each, 0xaa)),
             V(_mm512_permute_ps(each, 0xff))}};
  } else if constexpr (sizeof(V) == 64) {
    const auto of = [&](long long k) {
      return V(_mm512_permutexvar_pd(_mm512_setr_epi64(k, k, k, k, k + 2, k + 2, k + 2, k + 2), each));
    };
    return {{of(0), of(1), of(4), of(5)}};
  }
#endif
#if defined(__AVX2__)
  if constexpr (sizeof(V) == 32 && sizeof(Scalar<V>) == 4) {
    return {{V(_mm256_permute_ps(each, 0x00)), V(_mm256_permute_ps(each, 0x55)), V(_mm256_permute_ps(each, 0xaa)),
             V(_mm256_permute_ps(each, 0xff))}};
  } else if constexpr (sizeof(V) == 32) {
    return {{V(_mm256_permute4x64_pd(each, 0x00)), V(_mm256_permute4x64_pd(each, 0x55)), V(_mm256_permute4x64_pd(each, 0xaa)),
             V(_mm256_permute4x64_pd(each, 0xff))}};
  }
#endif
  if constexpr (sizeof(V) == 16) {
    const V low = unpack_low(each, each), high = unpack_high(each, each);
    if constexpr (sizeof(Scalar<V>) == 8) return {{low, low, high, high}};
    if constexpr (sizeof(Scalar<V>) == 4) {
      return {{unpack_low(low, low), unpack_high(low, low), unpack_low(high, high), unpack_high(high, high)}};
    }
  }
}

template <class V>
[[gnu::always_inline]] inline Records<V> load_records(const Scalar<V>* p) noexcept {  // as store_records left them
  return {{load_lanes<V>(p), load_lanes<V>(p + V::size), load_lanes<V>(p + 2 * V::size), load_lanes<V>(p + 3 * V::size)}};
}
template <class V>
[[gnu::always_inline]] inline void store_records(Scalar<V>* p, const Records<V>& records) noexcept {
  for (std::size_t n = 0; n < 4; ++n) store_lanes(p + n * V::size, records.at[n]);
}

template <class V>
[[gnu::always_inline]] inline Records<V> operator+(const Records<V>& a, const Records<V>& b) noexcept {
  return {{a.at[0] + b.at[0], a.at[1] + b.at[1], a.at[2] + b.at[2], a.at[3] + b.at[3]}};
}
template <class V>
[[gnu::always_inline]] inline Records<V> operator-(const Records<V>& a, const Records<V>& b) noexcept {
  return {{a.at[0] - b.at[0], a.at[1] - b.at[1], a.at[2] - b.at[2], a.at[3] - b.at[3]}};
}
template <class V>
[[gnu::always_inline]] inline Records<V> operator*(const Records<V>& a, const Records<V>& b) noexcept {
  return {{a.at[0] * b.at[0], a.at[1] * b.at[1], a.at[2] * b.at[2], a.at[3] * b.at[3]}};
}

#pragma GCC diagnostic pop

}  // namespace
}  // namespace dvdx
