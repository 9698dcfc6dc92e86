// Linear drag along one axis, through air that may move.
#pragma once

#include "dvdx/method.hpp"
#include "forces/contribution.hpp"

namespace dvdx {

// g = coefficient/mass; A = C = 0. A wind u adds P = B u and Q = D u: the force sees only v - u.
// Method::combined is the exact one.
Contribution drag(double g, double h, Method method, Expansion expansion) noexcept;

}  // namespace dvdx
