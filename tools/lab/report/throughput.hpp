// The cost of a step against the number of particles: where the state no longer fits into a cache, and the gain of many steps a
// call.
#pragma once

#include "report/build.hpp"

namespace dvdx::tool::report {

// Measures every precision of the options, from 256 particles by factors of four to four million, or as far as the time allows.
// Particles are repeated if the scene has fewer; they must not be joined. Throws Fault (bad_scene) if the scene cannot run.
[[nodiscard]] std::vector<Throughput> measure_throughput(const SceneFile& file, const MeasureOptions& options,
                                                         const Setup& setup, const ProgressCallback& progress);

}  // namespace dvdx::tool::report
