// The table of passes that one instruction set provides.
#pragma once

#include <array>
#include <cstddef>

#include "dvdx/isa.hpp"
#include "passes/rate/rate.hpp"
#include "passes/terms.hpp"

namespace dvdx {

template <class T>
struct Kernels {
  std::size_t lanes = 1;
  RatePass rate = nullptr;
  RateSinusoidPass rate_sinusoid = nullptr;
  std::array<std::array<StepBlock<T>, extras>, flows> step{};

  [[nodiscard]] StepBlock<T> at(Flow flow, Extras extra) const noexcept {
    return step[static_cast<std::size_t>(flow)][static_cast<std::size_t>(extra)];
  }
};

// Null where the binary or the machine lacks it.
template <class T>
const Kernels<T>* find_kernels(Isa isa, Arithmetic arithmetic) noexcept;

}  // namespace dvdx
