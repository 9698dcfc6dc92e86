// The comparison of chaotic runs beyond the horizon, by statistics that do not depend on each particle's position.
#pragma once

#include "report/reference.hpp"

namespace dvdx::tool::report {

// The statistics of one run over the sample times beyond the horizon.
struct Statistics {
  double energy = 0;          // J, the mean over time
  double kinetic = 0;         // J, the mean over time
  double stretch = 0;         // the largest
  std::vector<double> shape;  // m, each picked particle's mean position over time: [particle][axis]
};
[[nodiscard]] Statistics statistics_of(const Trace& trace, std::size_t first_time);

// m: the distance of each run's shape from the mean shape of the others, root mean square over particles.
[[nodiscard]] std::vector<double> shapes_apart(const std::vector<Statistics>& all);

// The scatter of the statistics over runs of the reference's scheme from starts near the scene's. Empty if the horizon leaves
// too few sample times, or if the runs would take more than `most_seconds`. Then `why` gives the reason.
struct Scatter {
  Beyond facts;
  std::vector<double> mean_shape;  // m, [particle][axis]
  std::string why{};
};
[[nodiscard]] Scatter scatter_beyond(const SceneFile& file, const Grid& grid, const Reference& reference, Effort effort,
                                     double most_seconds, const Setup& setup);

// The statistics of one run, compared with the scatter, in the same order.
[[nodiscard]] std::vector<BeyondValue> beside(const Scatter& scatter, const Statistics& run);

}  // namespace dvdx::tool::report
