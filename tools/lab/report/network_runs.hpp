// Measures the report of a scene with joined particles: schemes and sub-steps at the scene's own step.
#pragma once

#include "report/build.hpp"

namespace dvdx::tool::report {

[[nodiscard]] SceneReport measure_network_scene(const SceneFile& file, const MeasureOptions& options, const Setup& setup,
                                                const ProgressCallback& progress);

}  // namespace dvdx::tool::report
