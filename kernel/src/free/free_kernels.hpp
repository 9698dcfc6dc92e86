// The passes of particles that nothing joins, of one instruction set and arithmetic.
#pragma once

#include <array>
#include <cstddef>

#include "flow/layout.hpp"
#include "flow/rate.hpp"
#include "flow/terms.hpp"

namespace dvdx {

template <class T>
struct FreeKernels {
  std::size_t lanes = 1;
  std::array<std::array<StepBlock<T>, feature_sets>, flows> step{};
  LayoutKernels<T> layout;
  RatePass rate = nullptr;  // rates take no contracted form, and are made in float64 for both precisions
  RateSinusoidPass rate_sinusoid = nullptr;

  [[nodiscard]] StepBlock<T> at(Flow flow, StepFeatures features) const noexcept {
    return step[static_cast<std::size_t>(flow)][static_cast<std::size_t>(features)];
  }
};

}  // namespace dvdx
