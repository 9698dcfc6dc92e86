// Measures what a report shows of a scene.
#pragma once

#include <functional>

#include "report/results.hpp"
#include "report/simulation.hpp"

namespace dvdx::tool::report {

// Whether runs that take long go on beyond the horizon.
enum class LongRuns { until_horizon, whole };

struct MeasureOptions {
  std::vector<Precision> precisions;
  Effort effort = Effort::full;
  LongRuns long_runs = LongRuns::until_horizon;
};

// Called with a part of the whole, 0 to 1, and what is being measured.
using ProgressCallback = std::function<void(double part, const std::string& what)>;

[[nodiscard]] SceneReport measure_scene(const SceneFile& file, const MeasureOptions& options, const Setup& setup,
                                        const ProgressCallback& progress);

}  // namespace dvdx::tool::report
