// The rest pass: what a compensated state keeps in two columns of float32, as one float64, and back.
#pragma once

#include <cstddef>

#include "dvdx/isa.hpp"

namespace dvdx {

struct RestTable {
  // out[k] = value[k] + rest[k], exactly.
  void (*sum)(const float* value, const float* rest, std::size_t count, double* out) noexcept;
  // value[k] is the float32 nearest to in[k], and rest[k] the one nearest to what that leaves; 0 where value[k] is not finite.
  void (*split)(const double* in, std::size_t count, float* value, float* rest) noexcept;
};

extern const RestTable rest_reference, rest_sse2, rest_avx2, rest_avx512, rest_neon64;

// Of an instruction set that this binary and this machine have.
const RestTable& rest_table(Isa isa) noexcept;

}  // namespace dvdx
