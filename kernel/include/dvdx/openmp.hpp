// OpenMP as the caller's threads: link dvdx::openmp.
#pragma once

#include "dvdx/export.h"
#include "dvdx/parallel.hpp"

namespace dvdx {

// threads >= 1; 0 takes what OpenMP would.
[[nodiscard]] DVDX_EXPORT ParallelFor openmp(int threads = 0);

}  // namespace dvdx
