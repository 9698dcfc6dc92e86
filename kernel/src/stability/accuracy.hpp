// The accuracy of a scene's steps: whether they are exact, or with which power of the step their error goes. The size of the
// error of sweeps: stability/sweep_error.hpp.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "dvdx/scene.hpp"
#include "free/system.hpp"

namespace dvdx {

struct Accuracy {
  static constexpr int exact = std::numeric_limits<int>::max();
  int order = exact;
  std::vector<std::string> reasons;  // the reasons for that order; none if it is exact
};

// The accuracy of the path at a given time, as the step goes to zero. Rounding is left aside.
Accuracy accuracy(const Scene& scene, const System& system);

}  // namespace dvdx
