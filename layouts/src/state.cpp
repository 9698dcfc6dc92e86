#include "dvdx/layouts/state.hpp"

#include <cmath>

#include "dvdx/export.h"

namespace dvdx {

DVDX_EXPORT void Clock::advance(double h, double steps) noexcept {
  const double move = h * steps;
  const double move_rest = std::fma(h, steps, -move);
  const double sum = seconds + move;
  const double part = sum - seconds;
  const double sum_rest = (seconds - (sum - part)) + (move - part);
  const double rest = carry + (sum_rest + move_rest);
  seconds = sum + rest;
  carry = rest - (seconds - sum);
}

DVDX_EXPORT bool Clock::is_finite() const noexcept { return std::isfinite(seconds) && std::isfinite(carry); }

}  // namespace dvdx
