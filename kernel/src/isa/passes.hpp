// Every pass that one instruction set and arithmetic provides, in one table. Each table is defined in the file of its name and
// compiled with that instruction set's flags. A new pass is a member here, and a line each in wide_passes.inl.hpp and
// reference.cpp.
#pragma once

#include <array>
#include <cstddef>

#include "air/air.hpp"
#include "constraint/constraint.hpp"
#include "dvdx/isa.hpp"
#include "flow/residual.hpp"
#include "free/free_kernels.hpp"
#include "lifecycle/pass/emission.hpp"
#include "lifecycle/pass/removal.hpp"
#include "meet/rounds.hpp"
#include "skin/ball.hpp"
#include "springs/network.hpp"

namespace dvdx {

template <class T>
struct Kernels {
  FreeKernels<T> free;
  NetworkKernels<T> network;
  ConstraintKernels<T> constraint;
  RemovalKernels<T> removal;
  AirKernels<T> air;
  BallKernels<T> ball;
  MeetKernels<T> meet;
};

// Residuals, births and removals take no contracted form: they are the same in every arithmetic.
struct Passes {
  Kernels<float> f32;
  Kernels<double> f64;
  ResidualKernels residual;
  Compact compact4 = nullptr, compact8 = nullptr;
  Emit emit = nullptr;

  template <class T>
  [[nodiscard]] const Kernels<T>& of() const noexcept {
    if constexpr (sizeof(T) == sizeof(float)) return f32;
    if constexpr (sizeof(T) == sizeof(double)) return f64;
  }
};

extern const Passes reference_separate, reference_contracted;
extern const Passes sse2_separate;
extern const Passes avx2_separate, avx2_contracted, avx2_fast;
extern const Passes avx512_separate, avx512_contracted, avx512_fast;
extern const Passes neon64_separate, neon64_contracted, neon64_fast;

// Null if the binary or the machine lacks it.
const Passes* find_passes(Isa isa, Arithmetic arithmetic = Arithmetic::separate) noexcept;

}  // namespace dvdx
