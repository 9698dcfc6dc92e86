// Orders of convergence: what the mathematics says and what the runs show.
#pragma once

#include "report/reference.hpp"

namespace dvdx::tool::report {

struct Theory {
  std::optional<double> order;
  std::string note;  // "exact" or why there is none
};

[[nodiscard]] Theory theory_of(const SceneFile& file, Method method);

// Fits the finest runs of every method and precision that are clear of rounding and below 30 % error, marks them, and writes
// the slope to all runs of the method and precision.
[[nodiscard]] std::vector<Order> fit_orders(const SceneFile& file, const Reference& reference, std::vector<Run>& runs);

}  // namespace dvdx::tool::report
