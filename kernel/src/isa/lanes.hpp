// Everything that the wide bodies use of xsimd, in one place. Lanes<T, Arch> is a register of T; its operators are xsimd's.
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

// Names that xsimd does not have: its own load and store, which ask for alignment, would be found by their arguments first.
template <class V>
V load_lanes(const Scalar<V>* p) noexcept {
  return V::load_unaligned(p);
}
template <class V>
void store_lanes(Scalar<V>* p, V value) noexcept {
  value.store_unaligned(p);
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

#pragma GCC diagnostic pop

// Lanes below n.
template <class V>
Mask<V> first_lanes(std::size_t n) noexcept {
  alignas(64) static constexpr std::array<Scalar<V>, 16> numbers{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  return load_lanes<V>(numbers.data()) < V(static_cast<Scalar<V>>(n));
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
