// The passes of particles that come and go, one table an instruction set. Nothing in them is ever contracted.
#pragma once

#include "dvdx/isa.hpp"
#include "passes/emission/emission.hpp"
#include "passes/removal/removal.hpp"

namespace dvdx {

struct TurnoverTable {
  RemovalKernels<float> f32;
  RemovalKernels<double> f64;
  Compact compact4, compact8;
  Emit emit;

  template <class T>
  [[nodiscard]] const RemovalKernels<T>& of() const noexcept {
    if constexpr (sizeof(T) == sizeof(float)) return f32;
    if constexpr (sizeof(T) == sizeof(double)) return f64;
  }
};

extern const TurnoverTable turnover_reference, turnover_sse2, turnover_avx2, turnover_avx512, turnover_neon64;

// Of an instruction set that this binary and this machine have.
const TurnoverTable& turnover_table(Isa isa) noexcept;

}  // namespace dvdx
