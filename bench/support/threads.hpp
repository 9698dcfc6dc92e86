// Threads, if the build has them.
#pragma once

#include "dvdx/parallel.hpp"

namespace dvdx::bench {

// The largest number of threads worth timing: 2, or 1 without threads.
int most_threads();
ParallelFor on_threads(int threads);

}  // namespace dvdx::bench
