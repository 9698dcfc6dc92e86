// The steps of a run at which states are written.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace dvdx::tool {

struct Frames {
  double apart = 0;  // steps from one state to the next, >= 1: to the nearest whole step; 0: the last state alone

  [[nodiscard]] bool is_last_alone() const noexcept { return apart == 0; }

  // Returns the first step after `done` at which a run of `steps` writes a state. The last step always does.
  [[nodiscard]] std::uint64_t next(std::uint64_t done, std::uint64_t steps) const noexcept {
    if (is_last_alone() || apart >= static_cast<double>(steps)) return steps;
    auto frame = static_cast<std::uint64_t>(static_cast<double>(done) / apart);
    while (step_of(frame) <= done) ++frame;
    return std::min(steps, step_of(frame));
  }

  // Returns the number of states that such a run writes: step 0, one every `apart` steps, and the last.
  [[nodiscard]] std::uint64_t states(std::uint64_t steps) const noexcept {
    if (is_last_alone() || steps == 0) return 1;
    if (apart >= static_cast<double>(steps)) return 2;
    auto before = static_cast<std::uint64_t>(static_cast<double>(steps) / apart);  // frames before the end
    while (step_of(before) < steps) ++before;
    while (step_of(before - 1) >= steps) --before;
    return before + 1;
  }

 private:
  [[nodiscard]] std::uint64_t step_of(std::uint64_t frame) const noexcept {
    return static_cast<std::uint64_t>(std::llround(static_cast<double>(frame) * apart));
  }
};

// a_second > 0: states a second of simulated time, at most one a step. step: s, not 0.
[[nodiscard]] inline Frames frames_a_second(double a_second, double step) noexcept {
  const double apart = std::max(1.0, 1 / (a_second * std::abs(step)));
  const double whole = std::round(apart);
  constexpr double rounding = 1e-9;  // of a step that is written as a decimal number
  return {.apart = std::abs(apart - whole) <= rounding * whole ? whole : apart};
}

}  // namespace dvdx::tool
