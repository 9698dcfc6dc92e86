#include "hard_cases/cases.hpp"

#include <algorithm>
#include <iterator>

namespace dvdx::tool::stability {

std::vector<Case> all_cases() {
  std::vector<Case> all;
  for (auto* list : {&linear_cases, &drag_cases, &contact_cases, &bounce_cases, &network_cases, &heat_cases, &damping_cases,
                     &meet_cases, &input_cases}) {
    auto cases = (*list)();
    std::move(cases.begin(), cases.end(), std::back_inserter(all));
  }
  std::sort(all.begin(), all.end(), [](const Case& a, const Case& b) { return a.number < b.number; });
  return all;
}

}  // namespace dvdx::tool::stability
