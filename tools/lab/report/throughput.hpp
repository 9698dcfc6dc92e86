// The cost of a step over the number of particles: where the state no longer fits into a cache, what many steps a call save.
#pragma once

#include "report/build.hpp"

namespace dvdx::tool::report {

// In every precision of the options, from 256 particles by fours to four million, or as far as the time goes. The scene's
// particles are taken several times where it has fewer: nothing may join them. Throws Fault (bad_scene) where the scene cannot
// be run.
[[nodiscard]] std::vector<Throughput> measure_throughput(const SceneFile& file, const MeasureOptions& options,
                                                         const Setup& setup, const ProgressCallback& progress);

}  // namespace dvdx::tool::report
