// OpenMP as the caller's threads: link dvdx::openmp.
#pragma once

#include <memory>

#include "dvdx/export.h"
#include "dvdx/parallel.hpp"

namespace dvdx {

// A parallel region for each loop. Each loop waits for all threads, also for one that another program keeps off its core.
// threads >= 1; 0 takes what OpenMP would.
[[nodiscard]] DVDX_EXPORT ParallelFor openmp(int threads = 0);

// Threads of one OpenMP region, which take tasks of loops until the team is destroyed. A loop waits for tasks and not for
// threads: what a thread without a core leaves is taken by the others. Threads that find nothing to do spin for some 20 us,
// then sleep. One loop runs at a time; a second one, from another thread, runs on its caller alone.
class DVDX_EXPORT OpenMpTeam {
 public:
  // threads >= 1, the caller of a loop among them; 0 takes what OpenMP would. Throws std::system_error where the system has
  // no more threads.
  explicit OpenMpTeam(int threads = 0);
  ~OpenMpTeam();  // not while a loop runs
  OpenMpTeam(const OpenMpTeam&) = delete;
  OpenMpTeam& operator=(const OpenMpTeam&) = delete;

  // Valid as long as the team.
  [[nodiscard]] ParallelFor parallel_for() const noexcept;

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;  // null: one thread
};

}  // namespace dvdx
