// The constraint passes' scalar twins.
#pragma once

#include "passes/constraint/chain_reference.hpp"
#include "passes/constraint/constraint_reference.hpp"

namespace dvdx::reference {

template <class T, Arithmetic arithmetic>
constexpr ConstraintKernels<T> constraint_kernels() noexcept {
  return {.aim_pairs = aim_pairs<T>,
          .aim_chains = aim_chains<T, arithmetic>,
          .place_pairs = place_pairs<T, arithmetic>,
          .place_chains = place_chains<T, arithmetic>,
          .place_lines = place_lines<T, arithmetic>,
          .carry_pairs = carry_pairs<T, arithmetic>,
          .carry_chains = carry_chains<T, arithmetic>,
          .carry_lines = carry_lines<T, arithmetic>,
          .turn_pairs = turn_pairs<T, arithmetic>,
          .turn_chains = turn_chains<T, arithmetic>,
          .turn_lines = turn_lines<T, arithmetic>};
}

}  // namespace dvdx::reference
