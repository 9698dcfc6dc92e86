// The layout pass, a number at a time.
#pragma once

#include <array>
#include <cstddef>
#include <type_traits>

#include "flow/affine_reference.hpp"
#include "flow/layout.hpp"

namespace dvdx::reference {

template <class T>
T* three_of(const Threes<T>& threes, std::size_t i) noexcept {
  using Byte = std::conditional_t<std::is_const_v<T>, const std::byte, std::byte>;
  return reinterpret_cast<T*>(reinterpret_cast<Byte*>(threes.first) + static_cast<std::ptrdiff_t>(i) * threes.stride);
}

template <class T>
void load_columns(const Threes<const T>& from, std::size_t count, const std::array<T*, 3>& to) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) to[axis][i] = three_of(from, i)[axis];
  }
}

template <class T>
void store_columns(const std::array<const T*, 3>& from, std::size_t count, const Threes<T>& to) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) three_of(to, i)[axis] = from[axis][i];
  }
}

template <Arithmetic arithmetic, class T>
std::size_t step_structs(const Structs<T>& structs, std::size_t count, const Terms<T>& terms, const Steps<T>& steps) noexcept {
  for (std::size_t n = 0; n < steps.count; ++n) {
    const Offsets<T>& offsets = steps.offsets[n * steps.offsets_per_step];
    for (std::size_t i = 0; i < count; ++i) {
      T* const x = three_of(structs.x, i);
      T* const v = three_of(structs.v, i);
      for (std::size_t axis = 0; axis < 3; ++axis) affine<arithmetic>(terms, offsets, axis, i, x[axis], v[axis]);
    }
  }
  return count;
}

template <Arithmetic arithmetic, class T>
std::size_t step_tiles(const Tiles<T>& tiles, std::size_t count, const Terms<T>& terms, const Steps<T>& steps) noexcept {
  for (std::size_t n = 0; n < steps.count; ++n) {
    const Offsets<T>& offsets = steps.offsets[n * steps.offsets_per_step];
    for (std::size_t i = 0; i < count; ++i) {
      const std::ptrdiff_t at =
          static_cast<std::ptrdiff_t>(i / tiles.width) * tiles.stride + static_cast<std::ptrdiff_t>(i % tiles.width);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        affine<arithmetic>(terms, offsets, axis, i, tiles.x[axis][at], tiles.v[axis][at]);
      }
    }
  }
  return count;
}

template <class T, Arithmetic arithmetic>
constexpr LayoutKernels<T> scalar_layout() noexcept {
  constexpr StepStructs<T> structs = step_structs<arithmetic, T>;
  constexpr StepTiles<T> tiles = step_tiles<arithmetic, T>;
  return {.load = load_columns<T>,
          .store = store_columns<T>,
          .structs = {.drift = structs, .fused = structs, .driven_fused = structs},
          .tiles = {.drift = tiles, .fused = tiles, .driven_fused = tiles}};
}

}  // namespace dvdx::reference
