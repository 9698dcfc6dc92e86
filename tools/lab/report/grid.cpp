#include "report/grid.hpp"

#include <algorithm>
#include <cmath>

#include "scene_io/fault.hpp"
#include "scene_io/steps.hpp"

namespace dvdx::tool::report {
namespace {

// Powers of two around the scene's own step. The number of steps must stay whole, and very few steps tell little.
struct Range {
  int doublings;          // upper limit of doublings
  int halvings;           // upper limit of halvings
  double particle_steps;  // the limit of one run
};

Range range_for(Effort effort) { return effort == Effort::full ? Range{4, 6, 8e7} : Range{2, 2, 1e7}; }

std::vector<std::uint64_t> spread(std::uint64_t steps) {
  constexpr std::uint64_t most = 100;
  const auto samples = std::min(most, steps);
  std::vector<std::uint64_t> counts(samples + 1);
  for (std::uint64_t k = 0; k <= samples; ++k) counts[k] = k * steps / samples;
  return counts;
}

}  // namespace

double Grid::step(int halving) const { return std::ldexp(coarsest, -halving); }

std::uint64_t steps_of(const SceneFile& file) {
  const auto steps = steps_in(file.duration, file.step);
  if (!steps) throw Fault(Exit::bad_scene, file.path + ": duration must be " + steps.error());
  if (*steps == 0) throw Fault(Exit::bad_scene, file.path + ": duration must be at least one step to measure errors of");
  return *steps;
}

Grid grid_of(const SceneFile& file, std::size_t error_particles, Effort effort) {
  const auto range = range_for(effort);
  constexpr std::uint64_t few = 12;
  Grid grid{.coarsest = file.step, .coarse_steps = steps_of(file), .halvings = 0, .counts = {}};
  int doublings = 0;
  while (doublings < range.doublings && grid.coarse_steps % 2 == 0 && grid.coarse_steps / 2 >= few) {
    grid.coarse_steps /= 2;
    grid.coarsest *= 2;
    ++doublings;
  }
  grid.halvings = doublings;
  const auto work = [&](int halving) {
    return static_cast<double>(error_particles) * static_cast<double>(grid.steps(halving));
  };
  while (grid.halvings < doublings + range.halvings && work(grid.halvings + 1) <= range.particle_steps) ++grid.halvings;
  grid.counts = spread(grid.coarse_steps);
  return grid;
}

}  // namespace dvdx::tool::report
