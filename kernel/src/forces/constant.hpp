// A constant acceleration.
#pragma once

#include "dvdx/method.hpp"
#include "forces/contribution.hpp"

namespace dvdx {

// The gain of a constant acceleration. Method::combined is the exact one here. If the acceleration is combined with springs or
// drag, the gain is Combined::constant (combined.hpp).
Gain constant(double h, Method method) noexcept;

}  // namespace dvdx
