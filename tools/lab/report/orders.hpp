// Orders of convergence: by theory and from the runs.
#pragma once

#include "report/reference.hpp"

namespace dvdx::tool::report {

struct Theory {
  std::optional<double> order;
  std::string note;  // "exact", or the reason why there is none
};

[[nodiscard]] Theory theory_of(const SceneFile& file, Method method);

// Fits the finest runs of every method and precision that are clear of rounding and below 30 % error, and marks them. All runs
// of that method and precision get the slope.
[[nodiscard]] std::vector<Order> fit_orders(const SceneFile& file, const Reference& reference, std::vector<Run>& runs);

}  // namespace dvdx::tool::report
