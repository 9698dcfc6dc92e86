// A column: one number per particle, somewhere in memory that the caller owns.
#pragma once

#include <cstddef>
#include <limits>
#include <type_traits>

namespace dvdx {

// Element i lies at  base + (i / run) * stride + (i % run) * sizeof(T)  bytes.
//   structure of arrays   run = contiguous, stride unused
//   array of structures   run = 1,          stride = sizeof(struct)
//   tiles (AoSoA)         run = tile width, stride = bytes of a tile
// `capacity` is the number of elements that may be touched: elements from the particle count up to `capacity` are padding that
// a step may overwrite with anything. A view of memory that is exactly full has capacity == count; nothing behind it is read or
// written. base must be aligned to alignof(T), and so must every element (stride is a multiple of alignof(T)).
template <class T>
struct Column {
  static_assert(std::is_floating_point_v<std::remove_const_t<T>>);
  static constexpr std::size_t contiguous = std::numeric_limits<std::size_t>::max();

  T* base = nullptr;
  std::ptrdiff_t stride = 0;     // bytes from a run to the next
  std::size_t run = contiguous;  // consecutive elements: a power of two, or `contiguous`
  std::size_t capacity = 0;      // elements that may be touched

  [[nodiscard]] bool is_contiguous() const noexcept { return run == contiguous; }

  [[nodiscard]] T* at(std::size_t i) const noexcept {
    if (is_contiguous()) return base + i;
    using Byte = std::conditional_t<std::is_const_v<T>, const std::byte, std::byte>;
    auto* start = reinterpret_cast<Byte*>(base) + static_cast<std::ptrdiff_t>(i / run) * stride;
    return reinterpret_cast<T*>(start) + i % run;
  }
  T& operator[](std::size_t i) const noexcept { return *at(i); }
};

// A view of the caller's array of n elements. Nothing beyond element n-1 is touched.
template <class T>
Column<T> column(T* first, std::size_t n) noexcept {
  return {first, 0, Column<T>::contiguous, n};
}

}  // namespace dvdx
