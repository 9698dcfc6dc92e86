// Everything that the wide bodies use of xsimd, in one place. Lanes<T, Arch> is a register of T; its operators are xsimd's.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <xsimd/xsimd.hpp>

#include "dvdx/isa.hpp"

namespace dvdx {
namespace {  // every ISA has its own: nothing here may be shared between object files

template <class T, class Arch>
using Lanes = xsimd::batch<T, Arch>;

template <class V>
using Scalar = typename V::value_type;
template <class V>
using Mask = typename V::batch_bool_type;

// Names that xsimd does not have: its own load and store, which ask for alignment, would be found by their arguments first.
template <class V>
V load_lanes(const Scalar<V>* p) noexcept {
  return V::load_unaligned(p);
}
template <class V>
void store_lanes(Scalar<V>* p, V value) noexcept {
  value.store_unaligned(p);
}

// The lanes of a register that is in memory: registers' types may alias what they hold.
template <class V>
const Scalar<V>* lanes_at(const V& value) noexcept {
  static_assert(sizeof(V) == V::size * sizeof(Scalar<V>));
  return reinterpret_cast<const Scalar<V>*>(&value);
}

// -x to the last bit, of 0 too: for AVX-512 xsimd's own is 0 - x, which makes +0 of both.
template <class V>
V negative(V x) noexcept {
  return V(Scalar<V>(-0.0)) - x;
}

// Compare and select alone, never an instruction's own minimum: what those do with NaN differs from ISA to ISA.
template <class V>
V select(Mask<V> where, V a, V b) noexcept {
  return xsimd::select(where, a, b);
}
// As the scalar !=, which holds where either is NaN: what xsimd's says of that differs from ISA to ISA.
template <class V>
Mask<V> differ(V a, V b) noexcept {
  return ~(a == b);
}
template <class V>
bool any_lane(Mask<V> mask) noexcept {
  return xsimd::any(mask);
}
template <class V>
bool all_lanes(Mask<V> mask) noexcept {
  return xsimd::all(mask);
}
// Lane k as bit k.
template <class V>
std::uint64_t bits_of(Mask<V> mask) noexcept {
#if defined(__AVX512F__)
  using Register = typename Mask<V>::register_type;
  return static_cast<std::uint64_t>(static_cast<Register>(mask));
#else
#if defined(__AVX2__)
  if constexpr (sizeof(V) == 32 && sizeof(Scalar<V>) == 4) return static_cast<std::uint32_t>(_mm256_movemask_ps(mask));
  if constexpr (sizeof(V) == 32 && sizeof(Scalar<V>) == 8) return static_cast<std::uint32_t>(_mm256_movemask_pd(mask));
#elif defined(__SSE2__)
  if constexpr (sizeof(V) == 16 && sizeof(Scalar<V>) == 4) return static_cast<std::uint32_t>(_mm_movemask_ps(mask));
  if constexpr (sizeof(V) == 16 && sizeof(Scalar<V>) == 8) return static_cast<std::uint32_t>(_mm_movemask_pd(mask));
#else
  alignas(64) std::array<Scalar<V>, V::size> lanes;
  store_lanes(lanes.data(), select<V>(mask, V(Scalar<V>(1)), V(Scalar<V>(0))));
  std::uint64_t bits = 0;
  for (std::size_t k = 0; k < V::size; ++k) bits |= std::uint64_t{lanes[k] != 0} << k;
  return bits;
#endif
#endif
}

// Whether each of as many numbers as a register has lanes, below 2^31, is higher: lane k as bit k.
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
// Where the lanes of each choice of 8 stand.
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
// Writes those numbers whose bit is set, of as many as a register has lanes, beside each other, and up to most_chosen of any
// kind in all. How many are set.
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

// So many numbers are sorted at once, without a branch.
template <class V>
inline constexpr std::size_t sorted_at_once = sizeof(V) == 64 ? 16 : 8;

#if defined(__AVX2__)
// By six rounds of a lower and a higher one of two; the last lanes are the higher ones where a bit is set.
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

// Writes up to sorted_at_once numbers in ascending order, and what comes beyond them up to as many. As many are read.
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
  // The place of each is how many are lower.
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

// Where the whole of an AVX-512 register is asked for, g++ 12 warns of the unmasked intrinsic's undefined source.
template <class V>
V square_root(V value) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    return V(_mm512_maskz_sqrt_ps(__mmask16{0xffff}, value));
  } else if constexpr (sizeof(V) == 64) {
    return V(_mm512_maskz_sqrt_pd(__mmask8{0xff}, value));
  } else {
    return xsimd::sqrt(value);
  }
#elif defined(__aarch64__)
  if constexpr (sizeof(Scalar<V>) == 4) {
    return V(vsqrtq_f32(value));
  } else {
    return xsimd::sqrt(value);
  }
#else
  return xsimd::sqrt(value);
#endif
}
// xsimd 8.1's float root and quotient on neon64 are estimates, a few units in the last place away; the instructions are exact.
// In passes of either precision, divide by this; float64 has no such trap.
template <class V>
V quotient(V a, V b) noexcept {
#if defined(__aarch64__)
  if constexpr (sizeof(Scalar<V>) == 4) {
    return V(vdivq_f32(a, b));
  } else {
    return a / b;
  }
#else
  return a / b;
#endif
}
template <class V>
V magnitude(V value) noexcept {
  return select<V>(value < V(Scalar<V>(0)), -value, value);
}

// For bounds that say which surfaces are looked at, never for a number that a state depends on: the instructions' own, half as
// many as a compare and a select. Where x is NaN the bound stays what it was.
template <class V>
V low_bound(V bound, V x) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    return V(_mm512_maskz_min_ps(__mmask16{0xffff}, x, bound));
  } else if constexpr (sizeof(V) == 64) {
    return V(_mm512_maskz_min_pd(__mmask8{0xff}, x, bound));
  } else {
    return xsimd::min(x, bound);
  }
#elif defined(__aarch64__)
  if constexpr (sizeof(Scalar<V>) == 4) {
    return V(vminnmq_f32(x, bound));
  } else {
    return V(vminnmq_f64(x, bound));
  }
#else
  return xsimd::min(x, bound);
#endif
}
template <class V>
V high_bound(V bound, V x) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    return V(_mm512_maskz_max_ps(__mmask16{0xffff}, x, bound));
  } else if constexpr (sizeof(V) == 64) {
    return V(_mm512_maskz_max_pd(__mmask8{0xff}, x, bound));
  } else {
    return xsimd::max(x, bound);
  }
#elif defined(__aarch64__)
  if constexpr (sizeof(Scalar<V>) == 4) {
    return V(vmaxnmq_f32(x, bound));
  } else {
    return V(vmaxnmq_f64(x, bound));
  }
#else
  return xsimd::max(x, bound);
#endif
}

// xsimd 8.1's fma on AVX-512 is a multiply and an add, and its -a is 0 - a, which loses the sign of a zero; these are fused on
// every ISA that has the instruction: a b + c and -a b + c.
template <class V>
V fused_multiply_add(V a, V b, V c) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    return V(_mm512_fmadd_ps(a, b, c));
  } else if constexpr (sizeof(V) == 64) {
    return V(_mm512_fmadd_pd(a, b, c));
  } else {
    return xsimd::fma(a, b, c);
  }
#else
  return xsimd::fma(a, b, c);
#endif
}

template <class V>
V fused_negative_multiply_add(V a, V b, V c) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    return V(_mm512_fnmadd_ps(a, b, c));
  } else if constexpr (sizeof(V) == 64) {
    return V(_mm512_fnmadd_pd(a, b, c));
  } else {
    return xsimd::fma(-a, b, c);
  }
#elif defined(__FMA__)
  if constexpr (sizeof(Scalar<V>) == 4) {
    return V(_mm256_fnmadd_ps(a, b, c));
  } else {
    return V(_mm256_fnmadd_pd(a, b, c));
  }
#else
  return xsimd::fma(-a, b, c);
#endif
}

// a b where `where` holds, else 0: whatever a and b are there. AVX-512 does both at once.
template <class V>
V product_where(Mask<V> where, V a, V b) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    return V(_mm512_maskz_mul_ps(where, a, b));
  } else if constexpr (sizeof(V) == 64) {
    return V(_mm512_maskz_mul_pd(where, a, b));
  }
#endif
  return select<V>(where, a * b, V(Scalar<V>(0)));
}

// c + a b and c - a b where `where` holds, else c: whatever a and b are there. Fast arithmetic rounds once.
template <Arithmetic arithmetic, class V>
V add_product_where(Mask<V> where, V c, V a, V b) noexcept {
  if constexpr (arithmetic != Arithmetic::fast) {
    return c + product_where<V>(where, a, b);
#if defined(__AVX512F__)
  } else if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    return V(_mm512_mask3_fmadd_ps(a, b, c, where));
  } else if constexpr (sizeof(V) == 64) {
    return V(_mm512_mask3_fmadd_pd(a, b, c, where));
#endif
  } else {
    return select<V>(where, fused_multiply_add(a, b, c), c);
  }
}
template <Arithmetic arithmetic, class V>
V subtract_product_where(Mask<V> where, V c, V a, V b) noexcept {
  if constexpr (arithmetic != Arithmetic::fast) {
    return c - product_where<V>(where, a, b);
#if defined(__AVX512F__)
  } else if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    return V(_mm512_mask3_fnmadd_ps(a, b, c, where));
  } else if constexpr (sizeof(V) == 64) {
    return V(_mm512_mask3_fnmadd_pd(a, b, c, where));
#endif
  } else {
    return select<V>(where, fused_negative_multiply_add(a, b, c), c);
  }
}

// magic - (bits of x >> 1), the bits of a first guess of 1/sqrt(x).
template <class V, class Bits>
V magic_guess(V x, Bits magic) noexcept {
  using B = xsimd::batch<Bits, typename V::arch_type>;
  return xsimd::bitwise_cast<V>(B(magic) - (xsimd::bitwise_cast<B>(x) >> 1));
}

// Where nothing is optimised, g++'s gathers and shifts are macros, whose full masks it warns of.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-conversion"

// base[index[0]], base[index[1]], ... and back.
template <class V>
V gather_lanes(const Scalar<V>* base, const std::int32_t* index) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    return V(_mm512_i32gather_ps(_mm512_loadu_si512(index), base, 4));
  } else if constexpr (sizeof(V) == 64) {
    const __m256i at = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(index));
    return V(_mm512_i32gather_pd(at, base, 8));
  }
#elif defined(__AVX2__)
  if constexpr (sizeof(V) == 32 && sizeof(Scalar<V>) == 4) {
    const __m256i at = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(index));
    const __m256 all = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
    return V(_mm256_mask_i32gather_ps(_mm256_setzero_ps(), base, at, all, 4));
  } else if constexpr (sizeof(V) == 32) {
    const __m128i at = _mm_loadu_si128(reinterpret_cast<const __m128i*>(index));
    const __m256d all = _mm256_castsi256_pd(_mm256_set1_epi32(-1));
    return V(_mm256_mask_i32gather_pd(_mm256_setzero_pd(), base, at, all, 8));
  }
#endif
  alignas(64) Scalar<V> lanes[V::size];
  for (std::size_t k = 0; k < V::size; ++k) lanes[k] = base[index[k]];
  return load_lanes<V>(lanes);
}
template <class V>
void scatter_lanes(Scalar<V>* base, const std::int32_t* index, V value) noexcept {
  alignas(64) Scalar<V> lanes[V::size];
  store_lanes(lanes, value);
  for (std::size_t k = 0; k < V::size; ++k) base[index[k]] = lanes[k];
}

// The lanes of a register moved up by `by` = 1 or 2, the last ones of the register before it moving in.
template <int by, class V>
V moved_up(V before, V now) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64) {
    constexpr int lanes = static_cast<int>(V::size);
    const __m512i last = xsimd::bitwise_cast<xsimd::batch<std::int32_t, typename V::arch_type>>(before);
    const __m512i next = xsimd::bitwise_cast<xsimd::batch<std::int32_t, typename V::arch_type>>(now);
    if constexpr (sizeof(Scalar<V>) == 4) return V(_mm512_castsi512_ps(_mm512_alignr_epi32(next, last, lanes - by)));
    if constexpr (sizeof(Scalar<V>) == 8) return V(_mm512_castsi512_pd(_mm512_alignr_epi64(next, last, lanes - by)));
  }
#endif
#if defined(__AVX2__)
  if constexpr (sizeof(V) == 32 && sizeof(Scalar<V>) == 4) {
    const __m256 middle = _mm256_permute2f128_ps(before, now, 0x21);
    return V(_mm256_castsi256_ps(_mm256_alignr_epi8(_mm256_castps_si256(now), _mm256_castps_si256(middle), 16 - 4 * by)));
  } else if constexpr (sizeof(V) == 32) {
    const __m256d middle = _mm256_permute2f128_pd(before, now, 0x21);
    return by == 2 ? V(middle) : V(_mm256_shuffle_pd(middle, now, 0b0101));
  }
#endif
#if defined(__SSE2__)
  if constexpr (sizeof(V) == 16 && sizeof(Scalar<V>) == 4) {
    if constexpr (by == 2) return V(_mm_shuffle_ps(before, now, _MM_SHUFFLE(1, 0, 3, 2)));
    const __m128 middle = _mm_shuffle_ps(before, now, _MM_SHUFFLE(0, 0, 3, 3));
    return V(_mm_shuffle_ps(middle, now, _MM_SHUFFLE(2, 1, 2, 0)));
  } else if constexpr (sizeof(V) == 16) {
    return by == 2 ? before : V(_mm_shuffle_pd(before, now, 1));
  }
#elif defined(__aarch64__)
  if constexpr (sizeof(Scalar<V>) == 4) return V(vextq_f32(before, now, 4 - by));
  if constexpr (sizeof(Scalar<V>) == 8) return by == 2 ? before : V(vextq_f64(before, now, 1));
#endif
}

// ---- records: four numbers side by side ----------------------------------------------------------------------------------

// As many records as a register has lanes, in four registers. Which register holds which of them is each instruction set's own:
// wherever the transposes between records and lanes take least.
template <class V>
struct Records {
  V at[4];
};

// In each 128 bits: the first, or the last, halves of a and b in turn. (xsimd 8.1's zips are these on x86, others beyond it.)
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

// Whether a register holds every fourth of 16 records, or of 8 of them.
template <class V>
inline constexpr bool holds_every_fourth = sizeof(Scalar<V>) == 4 && V::size >= 8;

// The records of two ends: those of a register stand in turn from base + index[k] on, a first one, a second one, and so on.
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
// The records of a register stand side by side from base + index[k] on.
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
  const auto [a, b, c, d] = columns_of(Records<V>{{x, y, z, w}});  // four by four, its own inverse
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

// ---- threes: three numbers side by side, at any stride -------------------------------------------------------------------

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

// As many records as a register has lanes, of the threes at p, p + stride, and so on, where gather_records has them.
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

// Registers of 16 float hold what 8 lanes leave in two: the threes at p and 16 bytes behind it twice, and a row of two tiles.
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

// Bit k as lane k.
template <class V>
Mask<V> lanes_of(std::uint64_t bits) noexcept {
#if defined(__AVX512F__)
  return Mask<V>(static_cast<typename Mask<V>::register_type>(bits));
#else
  alignas(64) Scalar<V> lanes[V::size];
  for (std::size_t k = 0; k < V::size; ++k) lanes[k] = static_cast<Scalar<V>>((bits >> k) & 1U);
  return load_lanes<V>(lanes) != V(Scalar<V>(0));
#endif
}

// Lanes below n.
template <class V>
Mask<V> first_lanes(std::size_t n) noexcept {
  alignas(64) static constexpr std::array<Scalar<V>, 16> numbers{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  return load_lanes<V>(numbers.data()) < V(static_cast<Scalar<V>>(n));
}

// The first n lanes, 0 < n < V::size. Memory beyond them stays as the last store before this one left it.
template <class V>
void store_first_lanes(Scalar<V>* p, std::size_t n, V value) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    return _mm512_mask_storeu_ps(p, static_cast<__mmask16>((1U << n) - 1U), value);
  } else if constexpr (sizeof(V) == 64) {
    return _mm512_mask_storeu_pd(p, static_cast<__mmask8>((1U << n) - 1U), value);
  }
#endif
  store_lanes(p, select<V>(first_lanes<V>(n), value, load_lanes<V>(p)));
}

template <class V>
struct Halves {
  V first, second;
};

// a0 a2 a4 ... b0 b2 ..., and a1 a3 a5 ... b1 b3 ...
template <class V>
[[gnu::always_inline]] inline Halves<V> deinterleaved(V a, V b) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    const __m512i odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
    return {V(_mm512_permutex2var_ps(a, even, b)), V(_mm512_permutex2var_ps(a, odd, b))};
  } else {
    const __m512i even = _mm512_setr_epi64(0, 2, 4, 6, 8, 10, 12, 14);
    const __m512i odd = _mm512_setr_epi64(1, 3, 5, 7, 9, 11, 13, 15);
    return {V(_mm512_permutex2var_pd(a, even, b)), V(_mm512_permutex2var_pd(a, odd, b))};
  }
#elif defined(__AVX2__)
  constexpr int halves = _MM_SHUFFLE(3, 1, 2, 0);
  const auto in_order = [](__m256d x) { return _mm256_permute4x64_pd(x, halves); };
  if constexpr (sizeof(Scalar<V>) == 4) {
    const auto pick = [&](__m256 x) { return V(_mm256_castpd_ps(in_order(_mm256_castps_pd(x)))); };
    return {pick(_mm256_shuffle_ps(a, b, _MM_SHUFFLE(2, 0, 2, 0))), pick(_mm256_shuffle_ps(a, b, _MM_SHUFFLE(3, 1, 3, 1)))};
  } else {
    return {V(in_order(_mm256_unpacklo_pd(a, b))), V(in_order(_mm256_unpackhi_pd(a, b)))};
  }
#elif defined(__SSE2__)
  if constexpr (sizeof(Scalar<V>) == 4) {
    return {V(_mm_shuffle_ps(a, b, _MM_SHUFFLE(2, 0, 2, 0))), V(_mm_shuffle_ps(a, b, _MM_SHUFFLE(3, 1, 3, 1)))};
  } else {
    return {V(_mm_unpacklo_pd(a, b)), V(_mm_unpackhi_pd(a, b))};
  }
#else
  if constexpr (sizeof(Scalar<V>) == 4) {
    return {V(vuzp1q_f32(a, b)), V(vuzp2q_f32(a, b))};
  } else {
    return {V(vuzp1q_f64(a, b)), V(vuzp2q_f64(a, b))};
  }
#endif
}

// a0 b0 a1 b1 ..., the first half and the second: what deinterleaved() makes a and b of.
template <class V>
[[gnu::always_inline]] inline Halves<V> interleaved(V a, V b) noexcept {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64 && sizeof(Scalar<V>) == 4) {
    const __m512i low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
    const __m512i high = _mm512_setr_epi32(8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
    return {V(_mm512_permutex2var_ps(a, low, b)), V(_mm512_permutex2var_ps(a, high, b))};
  } else {
    const __m512i low = _mm512_setr_epi64(0, 8, 1, 9, 2, 10, 3, 11);
    const __m512i high = _mm512_setr_epi64(4, 12, 5, 13, 6, 14, 7, 15);
    return {V(_mm512_permutex2var_pd(a, low, b)), V(_mm512_permutex2var_pd(a, high, b))};
  }
#elif defined(__AVX2__)
  if constexpr (sizeof(Scalar<V>) == 4) {
    const __m256 low = _mm256_unpacklo_ps(a, b), high = _mm256_unpackhi_ps(a, b);
    return {V(_mm256_permute2f128_ps(low, high, 0x20)), V(_mm256_permute2f128_ps(low, high, 0x31))};
  } else {
    const __m256d low = _mm256_unpacklo_pd(a, b), high = _mm256_unpackhi_pd(a, b);
    return {V(_mm256_permute2f128_pd(low, high, 0x20)), V(_mm256_permute2f128_pd(low, high, 0x31))};
  }
#elif defined(__SSE2__)
  if constexpr (sizeof(Scalar<V>) == 4) {
    return {V(_mm_unpacklo_ps(a, b)), V(_mm_unpackhi_ps(a, b))};
  } else {
    return {V(_mm_unpacklo_pd(a, b)), V(_mm_unpackhi_pd(a, b))};
  }
#else
  if constexpr (sizeof(Scalar<V>) == 4) {
    return {V(vzip1q_f32(a, b)), V(vzip2q_f32(a, b))};
  } else {
    return {V(vzip1q_f64(a, b)), V(vzip2q_f64(a, b))};
  }
#endif
}

// a b + c and c - a b: one rounding or two, as the plan was asked for. Fast arithmetic fuses as contracted does.
template <Arithmetic arithmetic, class V>
V multiply_add(V a, V b, V c) noexcept {
  if constexpr (arithmetic != Arithmetic::separate) {
    return fused_multiply_add(a, b, c);
  } else {
    return a * b + c;
  }
}
template <Arithmetic arithmetic, class V>
V subtract_product(V c, V a, V b) noexcept {
  if constexpr (arithmetic != Arithmetic::separate) {
    return fused_negative_multiply_add(a, b, c);
  } else {
    return c - a * b;
  }
}

}  // namespace
}  // namespace dvdx
