// The network passes that one instruction set provides.
#pragma once

#include "passes/constraint/tables.inl.hpp"
#include "passes/network/grid.inl.hpp"
#include "passes/network/pairs.inl.hpp"
#include "passes/network/sequential.inl.hpp"

namespace dvdx {
namespace {

template <class T, class Arch, Arithmetic arithmetic>
constexpr NetworkKernels<T> network_kernels() noexcept {
  using V = Lanes<T, Arch>;
  return {.grid = kick_grid<V, arithmetic>,
          .graph = kick_graph<V, arithmetic>,
          .pairs = sum_pairs<V, arithmetic>,
          .add_pairs = add_pairs<V>,
          .strands = sweep_strands<V, arithmetic>,
          .colour = sweep_colour<V, arithmetic>,
          .take_shift = take_shift<V, arithmetic>,
          .constraint = constraint_kernels<T, Arch, arithmetic>()};
}

template <class Arch, Arithmetic arithmetic>
constexpr NetworkTables network_tables() noexcept {
  return {network_kernels<float, Arch, arithmetic>(), network_kernels<double, Arch, arithmetic>()};
}

}  // namespace
}  // namespace dvdx
