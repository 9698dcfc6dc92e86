// Measures what a report shows of a scene.
#pragma once

#include <functional>

#include "report/results.hpp"
#include "report/simulation.hpp"

namespace dvdx::tool::report {

struct MeasureOptions {
  std::vector<Precision> precisions;
  Effort effort = Effort::full;
};

// Called with a part of the whole, 0 to 1, and what is being measured.
using ProgressCallback = std::function<void(double part, const std::string& what)>;

[[nodiscard]] SceneReport measure_scene(const SceneFile& file, const MeasureOptions& options, const Setup& setup,
                                        const ProgressCallback& progress);

}  // namespace dvdx::tool::report
