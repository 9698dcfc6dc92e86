// Structure of arrays: six arrays, each contiguous.
#pragma once

#include <cstddef>
#include <utility>

#include "dvdx/export.h"
#include "dvdx/layouts/memory.hpp"
#include "dvdx/layouts/state.hpp"

namespace dvdx {

// The library's buffers are aligned to a cache line and padded to whole lines, the widest register, on every ISA: a buffer's
// layout never depends on the build or on the machine.
inline constexpr std::size_t alignment = 64;  // bytes
template <class T>
inline constexpr std::size_t padding = alignment / sizeof(T);  // 16 floats, 8 doubles

template <class T>
constexpr std::size_t padded(std::size_t count) noexcept {
  return (count + padding<T> - 1) / padding<T> * padding<T>;
}

// Elements from one column of the library's buffers to the next. The pitch is never near a multiple of 4096 bytes: at such
// distances the processor takes a load and a store for the same address (4K aliasing).
template <class T>
constexpr std::size_t column_pitch(std::size_t count) noexcept {
  constexpr std::size_t page = 4096 / sizeof(T);
  constexpr std::size_t sixth = 11 * padding<T>;  // 704 bytes: six columns spread over a page
  return (padded<T>(count) + page - 1 - sixth) / page * page + sixth;
}

// Owns an array that is aligned to a cache line. (A unique_ptr with a deleter would need <memory>, which takes a compiler as
// long as half of dvdx's headers.)
template <class T>
class AlignedArray {
 public:
  AlignedArray() = default;
  AlignedArray(T* first, std::size_t bytes, const Memory& memory) noexcept : first_(first), bytes_(bytes), memory_(memory) {}
  AlignedArray(AlignedArray&& other) noexcept { swap(other); }
  AlignedArray& operator=(AlignedArray&& other) noexcept {
    swap(other);
    return *this;
  }
  ~AlignedArray() {
    if (first_ != nullptr) release(memory_, first_, bytes_, alignment);
  }

  [[nodiscard]] T* get() const noexcept { return first_; }
  [[nodiscard]] T& operator[](std::size_t i) const noexcept { return first_[i]; }

 private:
  void swap(AlignedArray& other) noexcept {
    std::swap(first_, other.first_);
    std::swap(bytes_, other.bytes_);
    std::swap(memory_, other.memory_);
  }

  T* first_ = nullptr;
  std::size_t bytes_ = 0;
  Memory memory_{};
};

// Returns count zeros, aligned to 64 bytes. Throws std::bad_alloc if there is no memory: for set-up code, never inside a step.
template <class T>
DVDX_EXPORT AlignedArray<T> aligned_array(std::size_t count, const Memory& memory = {});

// A view of the caller's six arrays of n elements. Nothing beyond element n-1 is touched.
template <class T>
State<T> soa(T* x, T* y, T* z, T* vx, T* vy, T* vz, std::size_t n) noexcept {
  return {.x = {column(x, n), column(y, n), column(z, n)},
          .v = {column(vx, n), column(vy, n), column(vz, n)},
          .count = n,
          .clock = {}};
}

// Owning buffers, aligned and padded; a step may overwrite the padding.
template <class T>
class DVDX_EXPORT Soa {
 public:
  explicit Soa(std::size_t count, const Memory& memory = {});
  [[nodiscard]] State<T> view() noexcept;
  [[nodiscard]] std::size_t size() const noexcept { return count_; }

 private:
  std::size_t count_;
  AlignedArray<T> memory_;  // x, y, z, vx, vy, vz, column_pitch(count) apart
};

extern template class Soa<float>;
extern template class Soa<double>;

}  // namespace dvdx
