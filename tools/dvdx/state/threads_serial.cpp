#include "state/threads.hpp"

namespace dvdx::tool {

int most_threads() { return 1; }
int all_cores() { return 1; }

class Threads::Team {};

Threads::Threads(int /*count*/) {}
Threads::~Threads() = default;
ParallelFor Threads::parallel_for() const noexcept { return {}; }

}  // namespace dvdx::tool
