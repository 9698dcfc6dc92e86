#include "run/threads.hpp"

namespace dvdx::tool {

int most_threads() { return 1; }
int all_cores() { return 1; }
ParallelFor parallel(int /*threads*/) { return {}; }

}  // namespace dvdx::tool
