// The removal pass over registers. All it computes are ages and comparisons; what stays is moved, so that every instruction set
// has the same bits.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "isa/lanes.hpp"
#include "passes/removal/removal.hpp"

namespace dvdx {
namespace {

// The lanes at p + i, all of them or the first few; the others then hold copies of the first.
template <class V>
struct Whole {
  std::size_t i;
  V operator()(const Scalar<V>* p) const noexcept { return load_lanes<V>(p + i); }
};
template <class V>
struct Part {
  std::size_t i, count;
  V operator()(const Scalar<V>* p) const noexcept {
    alignas(64) std::array<Scalar<V>, V::size> lanes;
    lanes.fill(p[i]);
    std::copy_n(p + i, count, lanes.begin());
    return load_lanes<V>(lanes.data());
  }
};

constexpr std::uint64_t low_bits(std::size_t count) noexcept { return (std::uint64_t{1} << count) - 1; }

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

// test(load) for every register of `count` lanes: its mask's bits go to take(i, bits). A register's bits lie in one word.
template <class V, class Test, class Take>
[[gnu::always_inline]] inline void for_each_register(std::size_t count, const Test& test, const Take& take) noexcept {
  std::size_t i = 0;
  for (; i + V::size <= count; i += V::size) take(i, bits_of<V>(test(Whole<V>{i})));
  if (i < count) take(i, bits_of<V>(test(Part<V>{i, count - i})) & low_bits(count - i));
}

template <class V, class Test>
[[gnu::always_inline]] inline void mark(std::size_t count, std::uint64_t* gone, const Test& test) noexcept {
  for_each_register<V>(count, test, [gone](std::size_t i, std::uint64_t bits) { gone[i / 64] |= bits << (i % 64); });
}

template <class V>
V grown_old(V age, V h, std::size_t steps) noexcept {
  for (std::size_t n = 0; n < steps; ++n) age = age + h;
  return age;
}

template <class V>
void grow_old(Scalar<V>* age, std::size_t count, Scalar<V> h, std::size_t steps) noexcept {
  std::size_t i = 0;
  for (; i + V::size <= count; i += V::size) store_lanes(age + i, grown_old<V>(load_lanes<V>(age + i), V(h), steps));
  if (i == count) return;
  alignas(64) std::array<Scalar<V>, V::size> lanes;
  store_lanes(lanes.data(), grown_old<V>(Part<V>{i, count - i}(age), V(h), steps));
  std::copy_n(lanes.begin(), count - i, age + i);
}

template <class V>
void mark_aged(const Scalar<V>* age, const Scalar<V>* lifetime, std::size_t count, std::uint64_t* gone) noexcept {
  mark<V>(count, gone, [=](auto load) { return load(age) >= load(lifetime); });
}

template <class V>
std::size_t count_aged(const Scalar<V>* age, const Scalar<V>* lifetime, std::size_t count, Scalar<V> h,
                       std::size_t steps) noexcept {
  std::size_t aged = 0;
  for_each_register<V>(
      count, [=](auto load) { return grown_old<V>(load(age), V(h), steps) >= load(lifetime); },
      [&aged](std::size_t, std::uint64_t bits) { aged += static_cast<std::size_t>(std::popcount(bits)); });
  return aged;
}

// x - x is 0 where x is finite, else not a number; what xsimd's != says of that differs from ISA to ISA.
template <class V>
Mask<V> is_not_finite(V x) noexcept {
  return ~(x - x == V(Scalar<V>(0)));
}

template <class V>
void mark_placed(const RemovalTerms<Scalar<V>>& terms, const RemovalBlock<Scalar<V>>& block, std::uint64_t* gone) noexcept {
  const auto& x = block.x;
  for (std::size_t p = 0; p < terms.plane_count; ++p) {
    const auto& [normal, offset] = terms.planes[p];
    const V nx(normal[0]), ny(normal[1]), nz(normal[2]), least(offset);
    mark<V>(block.count, gone, [&](auto load) { return nx * load(x[0]) + ny * load(x[1]) + nz * load(x[2]) < least; });
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (terms.has_box) {
      const V min(terms.min[axis]), max(terms.max[axis]);
      mark<V>(block.count, gone, [&](auto load) {
        const V at = load(x[axis]);
        return (at < min) | (at > max);
      });
    }
    if (terms.removes_not_finite) {
      const auto* v = block.v[axis];
      mark<V>(block.count, gone, [&](auto load) { return is_not_finite<V>(load(x[axis])) | is_not_finite<V>(load(v)); });
    }
  }
}

// The bytes of the lanes whose bits are set, to the front of a register.
#if defined(__AVX512F__)
template <std::size_t bytes>
inline constexpr std::size_t compact_lanes = 64 / bytes;

template <std::size_t bytes>
__m512i packed(__m512i lanes, std::uint64_t keep) noexcept {
  if constexpr (bytes == 4) return _mm512_maskz_compress_epi32(static_cast<__mmask16>(keep), lanes);
  if constexpr (bytes == 8) return _mm512_maskz_compress_epi64(static_cast<__mmask8>(keep), lanes);
}

template <std::size_t bytes>
void pack(const std::byte* in, std::uint64_t keep, std::byte* out) noexcept {
  _mm512_storeu_si512(out, packed<bytes>(_mm512_loadu_si512(in), keep));
}
#elif defined(__AVX2__)
template <std::size_t bytes>
inline constexpr std::size_t compact_lanes = 32 / bytes;

// For each set of lanes, which 4-byte words of a register go to its front.
template <std::size_t bytes>
constexpr auto make_packings() noexcept {
  constexpr std::size_t lanes = compact_lanes<bytes>, words = bytes / 4;
  std::array<std::array<std::uint8_t, 8>, std::size_t{1} << lanes> packings{};
  for (std::size_t keep = 0; keep < packings.size(); ++keep) {
    std::size_t to = 0;
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      if ((keep >> lane & 1) == 0) continue;
      for (std::size_t word = 0; word < words; ++word) packings[keep][to++] = static_cast<std::uint8_t>(lane * words + word);
    }
  }
  return packings;
}
template <std::size_t bytes>
constexpr auto packings = make_packings<bytes>();

template <std::size_t bytes>
void pack(const std::byte* in, std::uint64_t keep, std::byte* out) noexcept {
  const auto* which = reinterpret_cast<const __m128i*>(packings<bytes>[keep].data());
  const __m256i from = _mm256_cvtepu8_epi32(_mm_loadl_epi64(which));
  const __m256i lanes = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(in));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), _mm256_permutevar8x32_epi32(lanes, from));
}
#else
template <std::size_t bytes>
inline constexpr std::size_t compact_lanes = 1;
#endif

// One element after another, without a branch: where one is gone, the next takes its place.
template <std::size_t bytes>
std::size_t compact_one_by_one(const std::byte* in, const std::uint64_t* gone, std::size_t from, std::size_t count,
                               std::byte* out, std::size_t kept) noexcept {
  for (std::size_t i = from; i < count; ++i) {
    std::memmove(out + kept * bytes, in + i * bytes, bytes);
    kept += (gone[i / 64] >> (i % 64) & 1) ^ 1;
  }
  return kept;
}

// A register is stored whole behind what is kept so far: that is at most as far as what has been loaded, so that in place, or
// from above, it overwrites nothing that is still to be read.
template <std::size_t bytes>
std::size_t compact(const std::byte* in, const std::uint64_t* gone, std::size_t count, std::byte* out) noexcept {
  constexpr std::size_t lanes = compact_lanes<bytes>;
  std::size_t i = 0, kept = 0;
  if constexpr (lanes > 1) {
    for (; i + lanes <= count; i += lanes) {
      const std::uint64_t keep = ~(gone[i / 64] >> (i % 64)) & low_bits(lanes);
      pack<bytes>(in + i * bytes, keep, out + kept * bytes);
      kept += static_cast<std::size_t>(std::popcount(keep));
    }
  }
  return compact_one_by_one<bytes>(in, gone, i, count, out, kept);
}

template <class T, class Arch>
constexpr RemovalKernels<T> removal_kernels() noexcept {
  using V = Lanes<T, Arch>;
  return {.grow_old = grow_old<V>, .mark_aged = mark_aged<V>, .count_aged = count_aged<V>, .mark_placed = mark_placed<V>};
}

}  // namespace
}  // namespace dvdx
