// Which steps a scene is run with, and when its runs are compared.
#pragma once

#include <cstdint>
#include <vector>

#include "report/results.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool::report {

struct Grid {
  double coarsest = 0;                // s: the largest step; every other one is this halved again and again
  std::uint64_t coarse_steps = 0;     // the run in coarsest steps
  int halvings = 0;                   // to the smallest step
  std::vector<std::uint64_t> counts;  // sample times in coarsest steps, from 0 to the end

  [[nodiscard]] double step(int halving) const;
  [[nodiscard]] double part(std::uint64_t parts) const { return coarsest / static_cast<double>(parts); }  // s
  [[nodiscard]] std::uint64_t steps(int halving) const { return coarse_steps << static_cast<unsigned>(halving); }
};

// How many of its own steps a scene takes. Throws Fault (bad_scene) where that is not a whole number or none.
[[nodiscard]] std::uint64_t steps_of(const SceneFile& file);

// The scene's own step is always among them.
[[nodiscard]] Grid grid_of(const SceneFile& file, std::size_t error_particles, Effort effort);

}  // namespace dvdx::tool::report
