// Between a state's columns and the memory that a step works in.
#pragma once

#include <cstddef>

#include "dvdx/layouts/convert.hpp"
#include "passes/residual/residual.hpp"

namespace dvdx {

// out[k] = the number of particle first + k, for k < n, and back.
template <class T>
void load(const ResidualKernels& /*table*/, const Column<T>& column, const Column<T>& /*residual*/, std::size_t first,
          std::size_t n, T* out) noexcept {
  gather(column, first, n, out);
}
template <class T>
void store(const ResidualKernels& /*table*/, const T* in, std::size_t first, std::size_t n, const Column<T>& column,
           const Column<T>& /*residual*/) noexcept {
  scatter(in, first, n, column);
}

// Compensated: the number is the sum of both columns.
inline void load(const ResidualKernels& table, const Column<float>& column, const Column<float>& residual, std::size_t first,
                 std::size_t n, double* out) noexcept {
  if (column.is_contiguous() && residual.is_contiguous()) return table.sum(column.at(first), residual.at(first), n, out);
  gather_sum(column, residual, first, n, out);
}
inline void store(const ResidualKernels& table, const double* in, std::size_t first, std::size_t n, const Column<float>& column,
                  const Column<float>& residual) noexcept {
  if (column.is_contiguous() && residual.is_contiguous()) return table.split(in, n, column.at(first), residual.at(first));
  scatter_sum(in, first, n, column, residual);
}

}  // namespace dvdx
