// The removal pass over registers, called after each step by lifecycle/live_chunks.hpp. It computes only ages and comparisons,
// and moves survivors, so that every instruction set has the same bits. The scalar twin: removal_reference.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <type_traits>

#include "lifecycle/pass/removal.hpp"
#include "simd/lanes.hpp"

namespace dvdx {
namespace {

// Loads and stores the lanes at p + i: all of them, or the first few. The others then hold copies of the first.
template <class V>
struct Whole {
  std::size_t i;
  V operator()(const Scalar<V>* p) const noexcept { return load_lanes<V>(p + i); }
  void put(V lanes, Scalar<V>* p) const noexcept { store_lanes(p + i, lanes); }
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
  void put(V all, Scalar<V>* p) const noexcept {
    alignas(64) std::array<Scalar<V>, V::size> lanes;
    store_lanes(lanes.data(), all);
    std::copy_n(lanes.begin(), count, p + i);
  }
};

// The same lanes, `by` particles further on.
template <class V>
Whole<V> moved(Whole<V> load, std::size_t by) noexcept {
  return {load.i + by};
}
template <class V>
Part<V> moved(Part<V> load, std::size_t by) noexcept {
  return {load.i + by, load.count};
}

constexpr std::uint64_t low_bits(std::size_t count) noexcept { return (std::uint64_t{1} << count) - 1; }

// Calls take(i, bits) with the mask's bits of test(load), for every register of `count` lanes. They lie in one word.
template <class V, class Test, class Take>
[[gnu::always_inline]] inline void for_each_register(std::size_t count, const Test& test, const Take& take) noexcept {
  std::size_t i = 0;
  for (; i + V::size <= count; i += V::size) take(i, bits_of<V>(test(Whole<V>{i})));
  if (i < count) take(i, bits_of<V>(test(Part<V>{i, count - i})) & low_bits(count - i));
}

// Whole words of marks are put together in a register.
template <class V, class Test>
[[gnu::always_inline]] inline void mark(std::size_t count, std::uint64_t* removed, const Test& test) noexcept {
  const std::size_t words = count / 64;
  for (std::size_t w = 0; w < words; ++w) {
    std::uint64_t bits = 0;
    for (std::size_t k = 0; k < 64; k += V::size) bits |= bits_of<V>(test(Whole<V>{64 * w + k})) << k;
    removed[w] |= bits;
  }
  const auto behind = [&test, words](auto load) { return test(moved(load, 64 * words)); };
  for_each_register<V>(count - 64 * words, behind,
                       [removed, words](std::size_t i, std::uint64_t bits) { removed[words] |= bits << i; });
}

template <class V>
V grown_old(V age, V h, std::size_t steps) noexcept {
  for (std::size_t n = 0; n < steps; ++n) age = age + h;
  return age;
}

template <class V>
void grow_old(Scalar<V>* age, std::size_t count, Scalar<V> h, std::size_t steps) noexcept {
  const auto grow = [=](auto lanes) { lanes.put(grown_old<V>(lanes(age), V(h), steps), age); };
  std::size_t i = 0;
  for (; i + V::size <= count; i += V::size) grow(Whole<V>{i});
  if (i < count) grow(Part<V>{i, count - i});
}

template <class V>
void grow_old_and_mark(Scalar<V>* age, const Scalar<V>* lifetime, std::size_t count, Scalar<V> h, std::size_t steps,
                       std::uint64_t* removed) noexcept {
  mark<V>(count, removed, [=](auto lanes) {
    const V grown = grown_old<V>(lanes(age), V(h), steps);
    lanes.put(grown, age);
    return grown >= lanes(lifetime);
  });
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

// x - x is 0 if x is finite, otherwise NaN.
template <class V>
Mask<V> is_not_finite(V x) noexcept {
  return differ(x - x, V(Scalar<V>(0)));
}

template <class V>
void mark_placed(const RemovalTerms<Scalar<V>>& terms, const RemovalBlock<Scalar<V>>& block, std::uint64_t* removed) noexcept {
  const auto& x = block.x;
  for (std::size_t p = 0; p < terms.plane_count; ++p) {
    const auto& [normal, offset] = terms.planes[p];
    const V nx(normal[0]), ny(normal[1]), nz(normal[2]), least(offset);
    mark<V>(block.count, removed, [&](auto load) { return nx * load(x[0]) + ny * load(x[1]) + nz * load(x[2]) < least; });
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (terms.has_box) {
      const V min(terms.min[axis]), max(terms.max[axis]);
      mark<V>(block.count, removed, [&](auto load) {
        const V at = load(x[axis]);
        return (at < min) | (at > max);
      });
    }
    if (terms.removes_not_finite) {
      const auto* v = block.v[axis];
      mark<V>(block.count, removed, [&](auto load) { return is_not_finite<V>(load(x[axis])) | is_not_finite<V>(load(v)); });
    }
  }
}

// Moves the elements of a register whose bits are set to its front.
#if defined(__AVX512F__)
inline constexpr std::size_t compact_bytes = 64;  // of a register

template <std::size_t bytes>
class Packing {
 public:
  explicit Packing(std::uint64_t keep) noexcept : keep_(static_cast<Bits>(keep)) {}
  void operator()(const std::byte* in, std::byte* out) const noexcept {
    _mm512_storeu_si512(out, front(_mm512_loadu_si512(in)));
  }

 private:
  using Bits = std::conditional_t<bytes == 4, __mmask16, __mmask8>;
  [[nodiscard]] __m512i front(__m512i all) const noexcept {
    if constexpr (bytes == 4) return _mm512_maskz_compress_epi32(keep_, all);
    if constexpr (bytes == 8) return _mm512_maskz_compress_epi64(keep_, all);
  }
  Bits keep_;
};
#elif defined(__AVX2__)
inline constexpr std::size_t compact_bytes = 32;

// For each set of kept elements, the 4-byte words of a register that go to its front.
template <std::size_t bytes>
constexpr auto make_packings() noexcept {
  constexpr std::size_t elements = compact_bytes / bytes, words = bytes / 4;
  std::array<std::array<std::uint8_t, 8>, std::size_t{1} << elements> packings{};
  for (std::size_t keep = 0; keep < packings.size(); ++keep) {
    std::size_t to = 0;
    for (std::size_t i = 0; i < elements; ++i) {
      if ((keep >> i & 1) == 0) continue;
      for (std::size_t word = 0; word < words; ++word) packings[keep][to++] = static_cast<std::uint8_t>(i * words + word);
    }
  }
  return packings;
}
template <std::size_t bytes>
constexpr auto packings = make_packings<bytes>();

template <std::size_t bytes>
class Packing {
 public:
  explicit Packing(std::uint64_t keep) noexcept
      : from_(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(packings<bytes>[keep].data())))) {}
  void operator()(const std::byte* in, std::byte* out) const noexcept {
    const __m256i all = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(in));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), _mm256_permutevar8x32_epi32(all, from_));
  }

 private:
  __m256i from_;
};
#else
// No instruction moves by a mask: elements move one after another, without a branch. A removed one is overwritten by the next.
inline constexpr std::size_t compact_bytes = 0;
template <std::size_t bytes>
class Packing;
#endif

template <std::size_t bytes>
[[gnu::always_inline]] inline void move_element(const std::byte* in, std::byte* out) noexcept {
  std::array<std::byte, bytes> element;
  std::memcpy(element.data(), in, bytes);
  std::memcpy(out, element.data(), bytes);
}

// The columns of one call, and how many elements they keep so far.
template <std::size_t bytes>
struct Compaction {
  const std::byte* const* in;
  std::byte* const* out;
  std::size_t columns;
  std::size_t kept = 0;

  // Stores registers whole behind the elements kept so far. That is never beyond what has been loaded, so that in place, or
  // from above, nothing still to be read is overwritten. all: `columns`, as a constant if possible.
  template <class Columns>
  [[gnu::always_inline]] void some(std::size_t i, std::uint64_t keep, std::size_t count, Columns all) noexcept {
    std::size_t k = 0;
    if constexpr (compact_bytes != 0) {
      constexpr std::size_t elements = compact_bytes / bytes;
      for (; k + elements <= count; k += elements) {
        const std::uint64_t here = keep >> k & low_bits(elements);
        const Packing<bytes> pack(here);
        for (std::size_t c = 0; c < all; ++c) pack(in[c] + (i + k) * bytes, out[c] + kept * bytes);
        kept += static_cast<std::size_t>(std::popcount(here));
      }
    }
    for (; k < count; ++k) {
      for (std::size_t c = 0; c < all; ++c) move_element<bytes>(in[c] + (i + k) * bytes, out[c] + kept * bytes);
      kept += keep >> k & 1;
    }
  }
  void some(std::size_t i, std::uint64_t keep, std::size_t count) noexcept {
    if (columns == compact_columns) return some(i, keep, count, std::integral_constant<std::size_t, compact_columns>());
    some(i, keep, count, columns);
  }

  void all(std::size_t i, std::size_t count) noexcept {
    for (std::size_t c = 0; c < columns; ++c) move_down(in[c] + i * bytes, out[c] + kept * bytes, count);
    kept += count;
  }

 private:
  // As std::memmove, for `to` not above `from`. It moves at most 64 elements, too few for a call to pay.
  static void move_down(const std::byte* from, std::byte* to, std::size_t count) noexcept {
    if (from == to) return;
    std::size_t k = 0;
    if constexpr (compact_bytes != 0) {
      constexpr std::size_t elements = compact_bytes / bytes;
      const Packing<bytes> as_it_is(low_bits(elements));
      for (; k + elements <= count; k += elements) as_it_is(from + k * bytes, to + k * bytes);
    }
    if (k < count) std::memmove(to + k * bytes, from + k * bytes, (count - k) * bytes);
  }
};

template <std::size_t bytes>
std::size_t compact(const std::byte* const* in, std::byte* const* out, std::size_t columns, const std::uint64_t* removed,
                    std::size_t count) noexcept {
  Compaction<bytes> compaction{in, out, columns};
  for (std::size_t i = 0; i < count; i += 64) {
    const std::size_t now = std::min<std::size_t>(64, count - i);
    if (removed[i / 64] == 0) {
      compaction.all(i, now);
    } else {
      compaction.some(i, ~removed[i / 64], now);
    }
  }
  return compaction.kept;
}

}  // namespace
}  // namespace dvdx
