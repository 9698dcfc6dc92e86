// The residual pass, a number at a time.
#pragma once

#include "dvdx/layouts/convert.hpp"
#include "flow/residual.hpp"

namespace dvdx::reference {

inline void sum_residuals(const float* value, const float* residual, std::size_t count, double* out) noexcept {
  for (std::size_t k = 0; k < count; ++k) {
    const double number = value[k];
    out[k] = number + double{residual[k]};
  }
}

inline void split_residuals(const double* in, std::size_t count, float* value, float* residual) noexcept {
  for (std::size_t k = 0; k < count; ++k) {
    value[k] = static_cast<float>(in[k]);
    residual[k] = residual_of(in[k], value[k]);
  }
}

}  // namespace dvdx::reference
