// A particle during one step, for the scalar twins.
#pragma once

#include <array>
#include <cmath>

#include "dvdx/isa.hpp"

namespace dvdx::reference {

template <class T>
struct Particle {
  std::array<T, 3> x0, v0;  // at the start of the step
  std::array<T, 3> x1, v1;  // at its end, as far as it is known
};

// a b + c and c - a b with one rounding or two.
template <Arithmetic arithmetic, class T>
T multiply_add(T a, T b, T c) noexcept {
  if constexpr (arithmetic == Arithmetic::contracted) return std::fma(a, b, c);
  return a * b + c;
}
template <Arithmetic arithmetic, class T>
T subtract_product(T c, T a, T b) noexcept {
  if constexpr (arithmetic == Arithmetic::contracted) return std::fma(-a, b, c);
  return c - a * b;
}

}  // namespace dvdx::reference
