// The constraint passes that one instruction set provides.
#pragma once

#include "passes/constraint/chain.inl.hpp"
#include "passes/constraint/constraint.inl.hpp"

namespace dvdx {
namespace {

template <class T, class Arch, Arithmetic arithmetic>
constexpr ConstraintKernels<T> constraint_kernels() noexcept {
  using V = Lanes<T, Arch>;
  return {.aim_pairs = aim_pairs<V>,
          .aim_chains = aim_chains<V, arithmetic>,
          .place_pairs = place_pairs<V, arithmetic>,
          .place_chains = place_chains<V, arithmetic>,
          .place_lines = place_lines<V, arithmetic>,
          .carry_pairs = carry_pairs<V, arithmetic>,
          .carry_chains = carry_chains<V, arithmetic>,
          .carry_lines = carry_lines<V, arithmetic>,
          .turn_pairs = turn_pairs<V, arithmetic>,
          .turn_chains = turn_chains<V, arithmetic>,
          .turn_lines = turn_lines<V, arithmetic>};
}

}  // namespace
}  // namespace dvdx
