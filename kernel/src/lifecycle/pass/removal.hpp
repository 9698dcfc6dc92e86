// The removal pass: which particles of a block go, and the others moved together in their order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace dvdx {

inline constexpr std::size_t max_boundaries = 8;

// The bounds that are looked at, rounded once to the state's type.
template <class T>
struct RemovalTerms {
  struct Plane {
    std::array<T, 3> normal;
    T offset;
  };
  std::array<Plane, max_boundaries> planes{};
  std::size_t plane_count = 0;
  bool has_box = false;
  std::array<T, 3> min{}, max{};
  bool removes_not_finite = false;

  [[nodiscard]] bool looks_at_places() const noexcept { return plane_count != 0 || has_box || removes_not_finite; }
};

// Particles in contiguous memory.
template <class T>
struct RemovalBlock {
  std::array<const T*, 3> x{}, v{};
  std::size_t count = 0;
};

// `removed` is a bit a particle, 64 of them a word, the first the lowest; marking sets bits and clears none.
template <class T>
struct RemovalKernels {
  // age[i] += h, `steps` times.
  void (*grow_old)(T* age, std::size_t count, T h, std::size_t steps) noexcept;
  // And marks those that are then at least as old as their lifetime.
  void (*grow_old_and_mark)(T* age, const T* lifetime, std::size_t count, T h, std::size_t steps,
                            std::uint64_t* removed) noexcept;
  // How many of them there will be: age is not changed.
  std::size_t (*count_aged)(const T* age, const T* lifetime, std::size_t count, T h, std::size_t steps) noexcept;
  void (*mark_placed)(const RemovalTerms<T>& terms, const RemovalBlock<T>& block, std::uint64_t* removed) noexcept;
};

inline constexpr std::size_t compact_columns = 8;  // at most, in one call

// From each of some columns of 4 or 8 bytes an element, those that are not removed, from in[c] to out[c] in their order; how
// many they are. out[c] may be in[c], or overlap it from below. Up to `count` elements may be overwritten at out[c].
using Compact = std::size_t (*)(const std::byte* const* in, std::byte* const* out, std::size_t columns,
                                const std::uint64_t* removed, std::size_t count) noexcept;

}  // namespace dvdx
