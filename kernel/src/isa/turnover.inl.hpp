// What an instruction set's file instantiates.
#pragma once

#include "isa/turnover.hpp"
#include "passes/emission/emission.inl.hpp"
#include "passes/removal/removal.inl.hpp"

namespace dvdx {
namespace {

template <class Arch>
constexpr TurnoverTable turnover_passes() noexcept {
  return {.f32 = removal_kernels<float, Arch>(),
          .f64 = removal_kernels<double, Arch>(),
          .compact4 = compact<4>,
          .compact8 = compact<8>,
          .emit = emit<Lanes<double, Arch>>};
}

}  // namespace
}  // namespace dvdx
