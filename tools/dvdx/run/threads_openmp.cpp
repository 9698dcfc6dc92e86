#include <algorithm>
#include <thread>

#include "dvdx/openmp.hpp"
#include "run/threads.hpp"

namespace dvdx::tool {

int most_threads() { return 1024; }
int all_cores() { return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, most_threads()); }
ParallelFor parallel(int threads) { return threads > 1 ? openmp(threads) : ParallelFor{}; }

}  // namespace dvdx::tool
