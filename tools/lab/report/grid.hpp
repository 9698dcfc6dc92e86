// The steps with which a scene is run, and the times at which its runs are compared.
#pragma once

#include <cstdint>
#include <vector>

#include "report/results.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool::report {

struct Grid {
  double coarsest = 0;                // s: the largest step; the others are powers of two below it
  std::uint64_t coarse_steps = 0;     // the number of coarsest steps in the run
  int halvings = 0;                   // from the coarsest step to the smallest
  std::vector<std::uint64_t> counts;  // sample times in coarsest steps, from 0 to the end

  [[nodiscard]] double step(int halving) const;
  [[nodiscard]] double part(std::uint64_t parts) const { return coarsest / static_cast<double>(parts); }  // s
  [[nodiscard]] std::uint64_t steps(int halving) const { return coarse_steps << static_cast<unsigned>(halving); }
};

// Returns the number of the scene's own steps. Throws Fault (bad_scene) if that is not a whole number, or zero.
[[nodiscard]] std::uint64_t steps_of(const SceneFile& file);

// The grid always contains the scene's own step.
[[nodiscard]] Grid grid_of(const SceneFile& file, std::size_t error_particles, Effort effort);

}  // namespace dvdx::tool::report
