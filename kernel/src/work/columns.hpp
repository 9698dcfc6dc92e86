// Columns of numbers from the caller's memory, and how much they take.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "dvdx/layouts/soa.hpp"

namespace dvdx {

template <class T>
class Columns {
 public:
  explicit Columns(const Memory& source) : source_(source) {}

  // `size` elements, aligned, with `margin` more before and after them.
  T* add(std::size_t size, T fill = T(0), std::size_t margin = 0) {
    T* const first = allocate(size + 2 * margin, fill);
    return first + margin;
  }
  // Three of them, column_pitch apart.
  std::array<T*, 3> add_axes(std::size_t size, T fill = T(0), std::size_t margin = 0) {
    const std::size_t pitch = column_pitch<T>(size + 2 * margin);
    T* const first = allocate(3 * pitch, fill) + margin;
    return {first, first + pitch, first + 2 * pitch};
  }

  [[nodiscard]] std::size_t count() const noexcept { return memory_.size(); }
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

 private:
  T* allocate(std::size_t elements, T fill) {
    memory_.push_back(aligned_array<T>(elements, source_));
    bytes_ += elements * sizeof(T);
    if (fill != T(0)) std::fill_n(memory_.back().get(), elements, fill);
    return memory_.back().get();
  }

  Memory source_;
  std::vector<AlignedArray<T>> memory_;
  std::size_t bytes_ = 0;
};

template <class Element>
[[nodiscard]] std::size_t bytes_of(const std::vector<Element>& list) noexcept {
  return list.size() * sizeof(Element);
}

}  // namespace dvdx
