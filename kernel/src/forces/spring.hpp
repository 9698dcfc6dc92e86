// An anchored spring, damped or not, along one axis. The exact step, with its derivation: combined.cpp.
#pragma once

#include "dvdx/method.hpp"
#include "forces/combined.hpp"
#include "forces/contribution.hpp"

namespace dvdx {

// W = stiffness/mass, g = damping/mass. Spring and damping are one force. Method::combined is the exact one.
Contribution spring(double W, double g, double h, Method method) noexcept;

// The same from the exact step of this spring alone.
Contribution by_method(const Combined& exact, double W, double g, double h, Method method) noexcept;

}  // namespace dvdx
