// The removal pass: marks the particles of a block that go, and moves the others together in their order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace dvdx {

inline constexpr std::size_t max_boundaries = 8;

// The bounds that particles are tested against, rounded once to the state's type.
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

// removed: one bit for each particle, 64 in a word, the lowest first. Marking sets bits and clears none.
template <class T>
struct RemovalKernels {
  // age[i] += h, `steps` times.
  void (*grow_old)(T* age, std::size_t count, T h, std::size_t steps) noexcept;
  // Also marks the particles that are then at least as old as their lifetime.
  void (*grow_old_and_mark)(T* age, const T* lifetime, std::size_t count, T h, std::size_t steps,
                            std::uint64_t* removed) noexcept;
  // Returns how many grow_old_and_mark would mark, and does not change age.
  std::size_t (*count_aged)(const T* age, const T* lifetime, std::size_t count, T h, std::size_t steps) noexcept;
  void (*mark_placed)(const RemovalTerms<T>& terms, const RemovalBlock<T>& block, std::uint64_t* removed) noexcept;
};

inline constexpr std::size_t compact_columns = 8;  // at most, in one call

// Moves the elements that are not removed, in their order, from in[c] to out[c], for each of some columns of 4 or 8 bytes an
// element. Returns how many. out[c] may be in[c], or overlap it from below. Up to `count` elements there may be overwritten.
using Compact = std::size_t (*)(const std::byte* const* in, std::byte* const* out, std::size_t columns,
                                const std::uint64_t* removed, std::size_t count) noexcept;

}  // namespace dvdx
