// Registers: loads, compare and select, arithmetic, order of lanes. Lanes<T, Arch> is a register of T; its operators are those
// of xsimd, which nothing else includes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
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

// Names that xsimd does not have: its own load and store, which require alignment, would be found first through the arguments.
template <class V>
V load_lanes(const Scalar<V>* p) noexcept {
  return V::load_unaligned(p);
}
template <class V>
void store_lanes(Scalar<V>* p, V value) noexcept {
  value.store_unaligned(p);
}

// The lanes of a register in memory. The types of registers may alias what they hold.
template <class V>
const Scalar<V>* lanes_at(const V& value) noexcept {
  static_assert(sizeof(V) == V::size * sizeof(Scalar<V>));
  return reinterpret_cast<const Scalar<V>*>(&value);
}

// -x to the last bit, for 0 too. For AVX-512 xsimd's own is 0 - x, which is +0 for both zeros.
template <class V>
V negative(V x) noexcept {
  return V(Scalar<V>(-0.0)) - x;
}

// Only compare and select, never a minimum instruction: its result for NaN differs from ISA to ISA.
template <class V>
V select(Mask<V> where, V a, V b) noexcept {
  return xsimd::select(where, a, b);
}
// As the scalar !=, which holds if either is NaN. xsimd's result for NaN differs from ISA to ISA.
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

// Whole AVX-512 registers take a masked intrinsic: g++ 12 warns of the undefined source of the unmasked one.
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
// xsimd 8.1's float root and quotient on neon64 are estimates, a few units in the last place off; the instructions are exact.
// Passes of either precision divide by this function. In float64 alone it is not needed.
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

// For bounds that decide which surfaces are looked at, never for a number that a state depends on. The minimum instruction
// takes half as many instructions as compare and select. If x is NaN, the bound stays what it was.
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

// a b + c and -a b + c, fused on every ISA that has the instruction. xsimd 8.1's fma on AVX-512 is a multiply and an add, and
// its -a is 0 - a, which loses the sign of a zero.
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

// a b if `where` holds, otherwise 0, whatever a and b are. AVX-512 does both at once.
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

// c + a b and c - a b if `where` holds, otherwise c, whatever a and b are. Fast arithmetic rounds once.
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

// Without optimisation, g++'s gathers and shifts are macros, and it warns of their full masks.
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

// The lanes of a register moved up by `by` = 1 or 2. The last lanes of the register before it move in.
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

// Stores the first n lanes, 0 < n < V::size. Memory beyond them keeps its values, but may be read and written.
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

// a0 b0 a1 b1 ..., the first half and the second: the inverse of deinterleaved().
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

// a b + c and c - a b, with one rounding or two, as the plan was asked for. Fast arithmetic fuses as contracted does.
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
