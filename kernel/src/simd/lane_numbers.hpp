// Compares, chooses and sorts particles' numbers, as many as a register has lanes.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "simd/registers.hpp"

namespace dvdx {
namespace {

// Compares as many numbers as a register has lanes, all below 2^31. Bit k is set if number k is higher.
template <class V>
[[gnu::always_inline]] inline std::uint64_t bits_of_higher(const std::uint32_t* numbers, std::uint32_t than) noexcept {
  [[maybe_unused]] const auto bound = static_cast<std::int32_t>(than);
#if defined(__AVX512F__)
  if constexpr (V::size == 16) return _mm512_cmpgt_epu32_mask(_mm512_loadu_si512(numbers), _mm512_set1_epi32(bound));
#endif
#if defined(__AVX2__)
  if constexpr (V::size == 8) {
    const __m256i of = _mm256_loadu_si256(reinterpret_cast<const __m256i_u*>(numbers));
    const __m256i are = _mm256_cmpgt_epi32(of, _mm256_set1_epi32(bound));
    return static_cast<std::uint32_t>(_mm256_movemask_ps(_mm256_castsi256_ps(are)));
  }
#endif
#if defined(__SSE2__)
  if constexpr (V::size == 4) {
    const __m128i of = _mm_loadu_si128(reinterpret_cast<const __m128i_u*>(numbers));
    return static_cast<std::uint32_t>(_mm_movemask_ps(_mm_castsi128_ps(_mm_cmpgt_epi32(of, _mm_set1_epi32(bound)))));
  }
#endif
  std::uint64_t bits = 0;
  for (std::size_t k = 0; k < V::size; ++k) bits |= std::uint64_t{numbers[k] > than} << k;
  return bits;
}

#if defined(__AVX2__) && !defined(__AVX512F__)
// The lanes of each choice of 8, in ascending order.
constexpr std::array<std::array<std::uint8_t, 8>, 256> chosen_of_8() noexcept {
  std::array<std::array<std::uint8_t, 8>, 256> all{};
  for (std::size_t bits = 0; bits < all.size(); ++bits) {
    std::size_t count = 0;
    for (std::uint8_t k = 0; k < 8; ++k) {
      if ((bits >> k & 1U) != 0) all[bits][count++] = k;
    }
  }
  return all;
}
inline constexpr std::array<std::array<std::uint8_t, 8>, 256> places_of_chosen = chosen_of_8();
#endif

template <class V>
inline constexpr std::size_t most_chosen = V::size > 8 ? V::size : 8;
// Writes the numbers whose bit is set side by side, from as many as a register has lanes. Writes up to most_chosen elements in
// all, the rest of any value. Returns how many bits are set.
template <class V>
[[gnu::always_inline]] inline std::size_t store_chosen(std::uint32_t* to, const std::uint32_t* numbers,
                                                       std::uint64_t bits) noexcept {
#if defined(__AVX512F__)
  if constexpr (V::size == 16) {
    const auto mask = static_cast<__mmask16>(bits);
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(mask, _mm512_loadu_si512(numbers)));
  } else {
    const __m256i of = _mm256_loadu_si256(reinterpret_cast<const __m256i_u*>(numbers));
    _mm256_storeu_si256(reinterpret_cast<__m256i_u*>(to), _mm256_maskz_compress_epi32(static_cast<__mmask8>(bits), of));
  }
#elif defined(__AVX2__)
  const auto* const places = reinterpret_cast<const __m128i_u*>(places_of_chosen[bits].data());
  __m256i of;
  if constexpr (V::size == 8) {
    of = _mm256_loadu_si256(reinterpret_cast<const __m256i_u*>(numbers));
  } else {
    of = _mm256_castsi128_si256(_mm_loadu_si128(reinterpret_cast<const __m128i_u*>(numbers)));
  }
  const __m256i chosen = _mm256_permutevar8x32_epi32(of, _mm256_cvtepu8_epi32(_mm_loadl_epi64(places)));
  _mm256_storeu_si256(reinterpret_cast<__m256i_u*>(to), chosen);
#else
  std::size_t count = 0;
  for (std::size_t k = 0; k < V::size; ++k) {
    to[count] = numbers[k];
    count += bits >> k & 1U;
  }
  return count;
#endif
  return static_cast<std::size_t>(std::popcount(bits));
}

// The count of numbers that are sorted at once, without a branch.
template <class V>
inline constexpr std::size_t sorted_at_once = sizeof(V) == 64 ? 16 : 8;

#if defined(__AVX2__)
// Sorts by six rounds of compare and exchange. The lanes whose bit is set get the higher of the two numbers.
[[gnu::always_inline]] inline __m256i sorted_8(__m256i of) noexcept {
  const auto apart = [](__m256i a, __m256i b, auto higher) {
    return _mm256_blend_epi32(_mm256_min_epu32(a, b), _mm256_max_epu32(a, b), decltype(higher)::value);
  };
  const auto by_1 = [&](__m256i a) { return apart(a, _mm256_shuffle_epi32(a, 0xb1), std::integral_constant<int, 0xaa>()); };
  of = by_1(of);
  of = apart(of, _mm256_shuffle_epi32(of, 0x1b), std::integral_constant<int, 0xcc>());
  of = by_1(of);
  of = apart(of, _mm256_permutevar8x32_epi32(of, _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0)),
             std::integral_constant<int, 0xf0>());
  of = apart(of, _mm256_shuffle_epi32(of, 0x4e), std::integral_constant<int, 0xcc>());
  return by_1(of);
}
#endif
#if defined(__AVX512F__)
[[gnu::always_inline]] inline __m512i sorted_16(__m512i of) noexcept {
  const auto apart = [](__m512i a, __m512i b, __mmask16 higher) {
    return _mm512_mask_max_epu32(_mm512_maskz_min_epu32(__mmask16{0xffff}, a, b), higher, a, b);
  };
  const auto by = [&](__m512i a, auto order, __mmask16 higher) {
    return apart(a, _mm512_maskz_shuffle_epi32(__mmask16{0xffff}, a, decltype(order)::value), higher);
  };
  using Next = std::integral_constant<_MM_PERM_ENUM, static_cast<_MM_PERM_ENUM>(0xb1)>;
  using Second = std::integral_constant<_MM_PERM_ENUM, static_cast<_MM_PERM_ENUM>(0x4e)>;
  using Back = std::integral_constant<_MM_PERM_ENUM, static_cast<_MM_PERM_ENUM>(0x1b)>;
  const auto from = [](__m512i a, __m512i at) { return _mm512_maskz_permutexvar_epi32(__mmask16{0xffff}, at, a); };
  const __m512i back_8 = _mm512_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0, 15, 14, 13, 12, 11, 10, 9, 8);
  const __m512i back_16 = _mm512_setr_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
  const __m512i fourth = _mm512_setr_epi32(4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11);
  of = by(of, Next(), 0xaaaa);
  of = by(of, Back(), 0xcccc);
  of = by(of, Next(), 0xaaaa);
  of = apart(of, from(of, back_8), 0xf0f0);
  of = by(of, Second(), 0xcccc);
  of = by(of, Next(), 0xaaaa);
  of = apart(of, from(of, back_16), 0xff00);
  of = apart(of, from(of, fourth), 0xf0f0);
  of = by(of, Second(), 0xcccc);
  return by(of, Next(), 0xaaaa);
}
#endif

// Writes count <= sorted_at_once numbers in ascending order. Reads and writes at most sorted_at_once, the rest of any value.
template <class V>
[[gnu::always_inline]] inline void store_sorted(std::uint32_t* to, const std::uint32_t* numbers, std::size_t count) noexcept {
#if defined(__AVX512F__)
  if (sorted_at_once<V> == 16 && count > 8) {
    const auto there = static_cast<__mmask16>((1U << count) - 1U);
    return _mm512_storeu_si512(to, sorted_16(_mm512_mask_loadu_epi32(_mm512_set1_epi32(-1), there, numbers)));
  }
#endif
#if defined(__AVX2__)
  const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  const __m256i is_beyond = _mm256_cmpgt_epi32(lanes, _mm256_set1_epi32(static_cast<int>(count) - 1));
  const __m256i of = _mm256_or_si256(_mm256_loadu_si256(reinterpret_cast<const __m256i_u*>(numbers)), is_beyond);
  _mm256_storeu_si256(reinterpret_cast<__m256i_u*>(to), sorted_8(of));
#else
  // The place of a number is how many are lower.
  alignas(16) std::array<std::uint32_t, 8> of, place;
#if defined(__SSE2__)
  const auto part = [&](int lane) {
    const __m128i is_there =
        _mm_cmplt_epi32(_mm_setr_epi32(lane, lane + 1, lane + 2, lane + 3), _mm_set1_epi32(static_cast<std::int32_t>(count)));
    const __m128i all = _mm_loadu_si128(reinterpret_cast<const __m128i_u*>(numbers + lane));
    return _mm_or_si128(_mm_and_si128(is_there, all), _mm_andnot_si128(is_there, _mm_set1_epi32(0x7fffffff)));
  };
  const __m128i first = part(0), second = part(4);
  __m128i before_first = _mm_setzero_si128(), before_second = before_first;
  const auto count_lower = [&](__m128i all) {
    before_first = _mm_sub_epi32(before_first, _mm_cmpgt_epi32(first, all));
    before_second = _mm_sub_epi32(before_second, _mm_cmpgt_epi32(second, all));
  };
  for (const __m128i four : {first, second}) {
    count_lower(_mm_shuffle_epi32(four, 0x00));
    count_lower(_mm_shuffle_epi32(four, 0x55));
    count_lower(_mm_shuffle_epi32(four, 0xaa));
    count_lower(_mm_shuffle_epi32(four, 0xff));
  }
  _mm_store_si128(reinterpret_cast<__m128i*>(of.data()), first);
  _mm_store_si128(reinterpret_cast<__m128i*>(of.data() + 4), second);
  _mm_store_si128(reinterpret_cast<__m128i*>(place.data()), before_first);
  _mm_store_si128(reinterpret_cast<__m128i*>(place.data() + 4), before_second);
#else
  for (std::uint32_t k = 0; k < 8; ++k) {
    of[k] = k < count ? numbers[k] : 0x7fffffffU;
    place[k] = 0;
  }
  for (const std::uint32_t other : of) {
    for (std::size_t k = 0; k < 8; ++k) place[k] += other < of[k] ? 1U : 0U;
  }
#endif
  for (std::size_t k = 0; k < 8; ++k) to[place[k]] = of[k];
#endif
}

}  // namespace
}  // namespace dvdx
