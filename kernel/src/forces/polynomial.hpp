// An acceleration that is a polynomial of time.
#pragma once

#include <array>

#include "dvdx/layouts/state.hpp"
#include "dvdx/method.hpp"
#include "forces/contribution.hpp"

namespace dvdx {

inline constexpr int polynomial_terms = 8;
using Polynomial8 = std::array<double, polynomial_terms>;  // coefficients of 1, t, t^2, ...; the missing ones are 0

// The same polynomial in the local time tau = t - clock.
Polynomial8 shift(const Polynomial8& coefficients, const Clock& clock) noexcept;

// The gain of tau^k, k = 0..7. Method::symplectic_euler sees only k = 0; Method::combined is the exact one here (with springs
// or drag: combined_monomial).
Gain monomial(int k, double h, Method method) noexcept;

}  // namespace dvdx
