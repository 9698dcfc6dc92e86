// Which steps a scene is run with, and when its runs are compared.
#pragma once

#include <cstdint>
#include <vector>

#include "report/results.hpp"
#include "scene_file.hpp"

namespace dvdx::tool::report {

struct Grid {
  double coarsest = 0;                // s: the largest step; every other one is this halved again and again
  std::uint64_t coarse_steps = 0;     // the run in coarsest steps
  int halvings = 0;                   // to the smallest step
  std::vector<std::uint64_t> counts;  // sample times in coarsest steps, from 0 to the end

  [[nodiscard]] double step(int halving) const;
  [[nodiscard]] std::uint64_t steps(int halving) const { return coarse_steps << static_cast<unsigned>(halving); }
};

// The scene's own step is always among them.
[[nodiscard]] Grid grid_of(const SceneFile& file, std::size_t error_particles, Effort effort);

}  // namespace dvdx::tool::report
