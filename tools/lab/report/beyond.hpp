// The comparison of chaotic runs beyond the horizon: not of where particles are, but of what does not depend on it.
#pragma once

#include "report/reference.hpp"

namespace dvdx::tool::report {

// The quantities of one run, over the sample times beyond the horizon.
struct Statistics {
  double energy = 0;          // J, the mean over time
  double kinetic = 0;         // J, the mean over time
  double stretch = 0;         // the largest
  std::vector<double> shape;  // m, the mean over time of every picked particle: [particle][axis]
};
[[nodiscard]] Statistics statistics_of(const Trace& trace, std::size_t first_time);

// m: how far each one's shape is from the mean of the others', root mean square over particles.
[[nodiscard]] std::vector<double> shapes_apart(const std::vector<Statistics>& all);

// How they scatter over runs of the reference's scheme from starts that lie beside the scene's. Empty where the horizon leaves
// too few sample times, or where the runs would take more than `most_seconds`; then `why` says so.
struct Scatter {
  Beyond facts;
  std::vector<double> mean_shape;  // m, [particle][axis]
  std::string why{};
};
[[nodiscard]] Scatter scatter_beyond(const SceneFile& file, const Grid& grid, const Reference& reference, Effort effort,
                                     double most_seconds, const Setup& setup);

// One run's statistics beside those, in their order.
[[nodiscard]] std::vector<BeyondValue> beside(const Scatter& scatter, const Statistics& run);

}  // namespace dvdx::tool::report
