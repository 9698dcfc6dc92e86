// The network passes' scalar twins.
#pragma once

#include "passes/constraint/tables_reference.hpp"
#include "passes/network/grid_reference.hpp"
#include "passes/network/pairs_reference.hpp"
#include "passes/network/sequential_reference.hpp"

namespace dvdx::reference {

template <class T, Arithmetic arithmetic>
constexpr NetworkKernels<T> network_kernels() noexcept {
  return {.grid = kick_grid<T, arithmetic>,
          .graph = kick_graph<T, arithmetic>,
          .pairs = sum_pairs<T, arithmetic>,
          .add_pairs = add_pairs<T>,
          .strands = sweep_strands<T, arithmetic>,
          .colour = sweep_colour<T, arithmetic>,
          .take_shift = take_shift<T, arithmetic>,
          .constraint = constraint_kernels<T, arithmetic>()};
}

template <Arithmetic arithmetic>
constexpr NetworkTables network_tables() noexcept {
  return {network_kernels<float, arithmetic>(), network_kernels<double, arithmetic>()};
}

}  // namespace dvdx::reference
