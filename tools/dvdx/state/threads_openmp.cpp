#include <algorithm>
#include <thread>

#include "dvdx/openmp.hpp"
#include "state/threads.hpp"

namespace dvdx::tool {

int most_threads() { return 1024; }
int all_cores() { return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, most_threads()); }

class Threads::Team : public OpenMpTeam {
 public:
  using OpenMpTeam::OpenMpTeam;
};

Threads::Threads(int count) : team_(std::make_unique<Team>(count)) {}
Threads::~Threads() = default;
ParallelFor Threads::parallel_for() const noexcept { return team_->parallel_for(); }

}  // namespace dvdx::tool
