// The layout pass: copies the caller's structs into columns and back, or steps structs and tiles in place.
//
// Structs hold x and v as three adjacent numbers each, at any stride. Flows that are alike for all particles and touch nothing
// else (drift, fused, driven_fused) need no columns: an axis is a lane, so a register holds the threes of some particles, with
// their coefficients by lane. Other steps go through columns, by transposes. Only x and v are read or written: memory between
// them may belong to another thread.
#pragma once

#include <array>
#include <cstddef>

#include "flow/terms.hpp"

namespace dvdx {

// Three numbers of each particle: those of particle i start i * stride bytes behind `first`.
template <class T>
struct Threes {
  T* first = nullptr;
  std::ptrdiff_t stride = 0;
};
template <class T>
struct Structs {
  Threes<T> x, v;
};

// Six columns in tiles of `width` particles, a power of two: element i stands i / width * stride + i % width behind the first.
template <class T>
struct Tiles {
  std::array<T*, 3> x{}, v{};
  std::size_t width = 0;
  std::ptrdiff_t stride = 0;  // elements
};

// Steps the first particles, as many as fill whole registers, and returns their number.
template <class T>
using StepStructs = std::size_t (*)(const Structs<T>&, std::size_t count, const Terms<T>&, const Steps<T>&) noexcept;
template <class T>
using StepTiles = std::size_t (*)(const Tiles<T>&, std::size_t count, const Terms<T>&, const Steps<T>&) noexcept;

// A function for each flow that is stepped in place.
template <class Step>
struct AsTheyLie {
  Step drift = nullptr, fused = nullptr, driven_fused = nullptr;

  // Returns null if the flow needs columns.
  [[nodiscard]] Step at(Flow flow) const noexcept {
    if (flow == Flow::drift) return drift;
    if (flow == Flow::fused) return fused;
    return flow == Flow::driven_fused ? driven_fused : nullptr;
  }
};

template <class T>
struct LayoutKernels {
  // to[axis][k] = number `axis` of particle k, for k < count, and back.
  void (*load)(const Threes<const T>& from, std::size_t count, const std::array<T*, 3>& to) noexcept;
  void (*store)(const std::array<const T*, 3>& from, std::size_t count, const Threes<T>& to) noexcept;
  AsTheyLie<StepStructs<T>> structs;
  AsTheyLie<StepTiles<T>> tiles;
};

}  // namespace dvdx
