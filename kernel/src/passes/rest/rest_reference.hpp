// The rest pass, a number at a time.
#pragma once

#include "dvdx/layouts/convert.hpp"
#include "passes/rest/rest.hpp"

namespace dvdx::reference {

inline void sum_rests(const float* value, const float* rest, std::size_t count, double* out) noexcept {
  for (std::size_t k = 0; k < count; ++k) {
    const double number = value[k];
    out[k] = number + double{rest[k]};
  }
}

inline void split_rests(const double* in, std::size_t count, float* value, float* rest) noexcept {
  for (std::size_t k = 0; k < count; ++k) {
    value[k] = static_cast<float>(in[k]);
    rest[k] = rest_of(in[k], value[k]);
  }
}

}  // namespace dvdx::reference
