#include "support/threads.hpp"

#include <thread>

#ifdef DVDX_HAS_OPENMP
#include "dvdx/openmp.hpp"
#endif

namespace dvdx::bench {

#ifdef DVDX_HAS_OPENMP
int most_threads() { return std::thread::hardware_concurrency() > 1 ? 2 : 1; }
ParallelFor on_threads(int threads) {
  static const OpenMpTeam two(2);  // sleeps while a benchmark uses one thread
  return threads > 1 ? two.parallel_for() : ParallelFor{};
}
#else
int most_threads() { return 1; }
ParallelFor on_threads(int) { return {}; }
#endif

}  // namespace dvdx::bench
