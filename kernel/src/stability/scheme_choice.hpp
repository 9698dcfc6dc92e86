// The choice of a scheme for a scene that leaves it open.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "dvdx/plan.hpp"
#include "springs/frequencies.hpp"
#include "stability/sweep_error.hpp"

namespace dvdx {

// The layout of the springs in memory, which decides what a sub-step costs.
enum class SpringsLie { as_sheet, as_list };

struct Joined {
  std::size_t particles = 0, springs = 0;
  SpringsLie lie = SpringsLie::as_list;    // by leapfrog
  SpringsLie swept = SpringsLie::as_list;  // by sequential
  bool is_damped = false;
};

// Sets the scheme of a coupling that leaves it open, and the longest sub-step of sequential. rates: the springs', by sums,
// which are the same on every machine.
SchemeChoice take_scheme(Coupling& coupling, double step, const HighestRates& rates, const SweptNet& net, const Joined& joined);
// start: the particles' positions.
SchemeChoice take_scheme(Scene& scene, double step, std::span<const Vec3> start);

}  // namespace dvdx
