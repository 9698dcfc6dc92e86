// The residual pass in registers. It only converts, so the compiler is left to vectorise the loops.
#pragma once

#include <bit>
#include <cstdint>

#include "flow/residual.hpp"

namespace dvdx {
namespace {

void sum_residuals(const float* __restrict value, const float* __restrict residual, std::size_t count,
                   double* __restrict out) noexcept {
  for (std::size_t k = 0; k < count; ++k) out[k] = static_cast<double>(value[k]) + static_cast<double>(residual[k]);
}

void split_residuals(const double* __restrict in, std::size_t count, float* __restrict value,
                     float* __restrict residual) noexcept {
  for (std::size_t k = 0; k < count; ++k) {
    constexpr std::uint32_t exponent = 0x7F800000U;  // all ones where a float is not finite
    const auto high = static_cast<float>(in[k]);
    const auto low = static_cast<float>(in[k] - static_cast<double>(high));
    const bool is_finite = (std::bit_cast<std::uint32_t>(high) & exponent) != exponent;
    value[k] = high;
    // A choice between floats would be a branch, and keep the compiler from vectorising the loop: 10 times slower.
    residual[k] = std::bit_cast<float>(std::bit_cast<std::uint32_t>(low) & (is_finite ? ~0U : 0U));
  }
}

}  // namespace
}  // namespace dvdx
