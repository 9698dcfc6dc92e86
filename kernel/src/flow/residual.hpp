// The residual pass: converts numbers, kept by a compensated state in two columns of float32, to float64 and back.
#pragma once

#include <cstddef>

namespace dvdx {

struct ResidualKernels {
  // out[k] = value[k] + residual[k], exactly.
  void (*sum)(const float* value, const float* residual, std::size_t count, double* out) noexcept;
  // value[k] becomes the float32 nearest to in[k], and residual[k] the float32 nearest to in[k] - value[k], or 0 if value[k] is
  // not finite.
  void (*split)(const double* in, std::size_t count, float* value, float* residual) noexcept;
};

}  // namespace dvdx
