// Between a state's columns and the memory that a step works in.
#pragma once

#include <cstddef>

#include "dvdx/layouts/convert.hpp"

namespace dvdx {

// out[k] = the number of particle first + k, for k < n, and back.
template <class T>
void load(const Column<T>& column, const Column<T>& /*rest*/, std::size_t first, std::size_t n, T* out) noexcept {
  gather(column, first, n, out);
}
template <class T>
void store(const T* in, std::size_t first, std::size_t n, const Column<T>& column, const Column<T>& /*rest*/) noexcept {
  scatter(in, first, n, column);
}

// Compensated: the number is the sum of both columns.
inline void load(const Column<float>& column, const Column<float>& rest, std::size_t first, std::size_t n,
                 double* out) noexcept {
  gather_sum(column, rest, first, n, out);
}
inline void store(const double* in, std::size_t first, std::size_t n, const Column<float>& column,
                  const Column<float>& rest) noexcept {
  scatter_sum(in, first, n, column, rest);
}

}  // namespace dvdx
