// Threads, where the build has them.
#pragma once

#include "dvdx/parallel.hpp"

namespace dvdx::bench {

// The most threads worth timing: 2, or 1 where there are none.
int most_threads();
ParallelFor on_threads(int threads);

}  // namespace dvdx::bench
