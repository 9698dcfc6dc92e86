// The removal pass, scalar: written by hand beside removal.inl.hpp.
#pragma once

#include <cstring>

#include "lifecycle/pass/removal.hpp"

namespace dvdx::reference {

inline void mark(std::uint64_t* removed, std::size_t i, bool is_gone) noexcept {
  if (is_gone) removed[i / 64] |= std::uint64_t{1} << (i % 64);
}

template <class T>
void grow_old(T* age, std::size_t count, T h, std::size_t steps) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t n = 0; n < steps; ++n) age[i] = age[i] + h;
  }
}

template <class T>
void grow_old_and_mark(T* age, const T* lifetime, std::size_t count, T h, std::size_t steps, std::uint64_t* removed) noexcept {
  grow_old(age, count, h, steps);
  for (std::size_t i = 0; i < count; ++i) mark(removed, i, age[i] >= lifetime[i]);
}

template <class T>
std::size_t count_aged(const T* age, const T* lifetime, std::size_t count, T h, std::size_t steps) noexcept {
  std::size_t aged = 0;
  for (std::size_t i = 0; i < count; ++i) {
    T at = age[i];
    for (std::size_t n = 0; n < steps; ++n) at = at + h;
    if (at >= lifetime[i]) ++aged;
  }
  return aged;
}

// x - x is 0 if x is finite, otherwise NaN.
template <class T>
bool is_finite(T x) noexcept {
  return x - x == T(0);
}

template <class T>
void mark_placed(const RemovalTerms<T>& terms, const RemovalBlock<T>& block, std::uint64_t* removed) noexcept {
  for (std::size_t i = 0; i < block.count; ++i) {
    const T x = block.x[0][i], y = block.x[1][i], z = block.x[2][i];
    for (std::size_t p = 0; p < terms.plane_count; ++p) {
      const auto& plane = terms.planes[p];
      mark(removed, i, plane.normal[0] * x + plane.normal[1] * y + plane.normal[2] * z < plane.offset);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (terms.has_box) mark(removed, i, block.x[axis][i] < terms.min[axis] || block.x[axis][i] > terms.max[axis]);
      if (terms.removes_not_finite) mark(removed, i, !is_finite(block.x[axis][i]) || !is_finite(block.v[axis][i]));
    }
  }
}

template <std::size_t bytes>
std::size_t compact(const std::byte* const* in, std::byte* const* out, std::size_t columns, const std::uint64_t* removed,
                    std::size_t count) noexcept {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if ((removed[i / 64] >> (i % 64) & 1) != 0) continue;
    for (std::size_t c = 0; c < columns; ++c) std::memmove(out[c] + kept * bytes, in[c] + i * bytes, bytes);
    ++kept;
  }
  return kept;
}

}  // namespace dvdx::reference
