// The hard cases: one list for each subject, one small function for each check.
#pragma once

#include <vector>

#include "hard_cases/case.hpp"

namespace dvdx::tool::stability {

[[nodiscard]] std::vector<Case> linear_cases();   // single particles under linear forces
[[nodiscard]] std::vector<Case> drag_cases();     // coefficients, damping, forces of time
[[nodiscard]] std::vector<Case> contact_cases();  // rest, corners, friction
[[nodiscard]] std::vector<Case> bounce_cases();   // the result and the time of impacts
[[nodiscard]] std::vector<Case> network_cases();  // springs between particles
[[nodiscard]] std::vector<Case> heat_cases();     // sheets that crumple
[[nodiscard]] std::vector<Case> damping_cases();  // along springs
[[nodiscard]] std::vector<Case> meet_cases();     // cloth on itself and on cloth
[[nodiscard]] std::vector<Case> input_cases();    // unusual steps, masses and numbers; the same bits

inline constexpr int last_case = 50;

// All cases sorted by number: 1 to last_case, each once.
[[nodiscard]] std::vector<Case> all_cases();

}  // namespace dvdx::tool::stability
