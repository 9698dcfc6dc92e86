// The residual pass: what a compensated state keeps in two columns of float32, as one float64, and back.
#pragma once

#include <cstddef>

namespace dvdx {

struct ResidualKernels {
  // out[k] = value[k] + residual[k], exactly.
  void (*sum)(const float* value, const float* residual, std::size_t count, double* out) noexcept;
  // value[k] is the float32 nearest to in[k], and residual[k] the one nearest to what that leaves; 0 where value[k] is not
  // finite.
  void (*split)(const double* in, std::size_t count, float* value, float* residual) noexcept;
};

}  // namespace dvdx
