// Measures the contents of a report for a scene.
#pragma once

#include <functional>

#include "report/results.hpp"
#include "report/simulation.hpp"

namespace dvdx::tool::report {

// Whether long runs continue beyond the horizon.
enum class LongRuns { until_horizon, whole };

struct MeasureOptions {
  std::vector<Precision> precisions;
  Effort effort = Effort::full;
  LongRuns long_runs = LongRuns::until_horizon;
};

// Called with the completed part, 0 to 1, and the current measurement.
using ProgressCallback = std::function<void(double part, const std::string& what)>;

[[nodiscard]] SceneReport measure_scene(const SceneFile& file, const MeasureOptions& options, const Setup& setup,
                                        const ProgressCallback& progress);

}  // namespace dvdx::tool::report
