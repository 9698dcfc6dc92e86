// The threads of a run: OpenMP's where the build has it, else the calling thread alone.
#pragma once

#include "dvdx/parallel.hpp"

namespace dvdx::tool {

[[nodiscard]] int most_threads();  // that this build can use here
[[nodiscard]] int all_cores();     // what a run takes where it is not told
[[nodiscard]] ParallelFor parallel(int threads);

}  // namespace dvdx::tool
