// OpenMP as the caller's threads: link dvdx::openmp.
#pragma once

#include <memory>

#include "dvdx/export.h"
#include "dvdx/parallel.hpp"

namespace dvdx {

// Opens a parallel region for each loop. Each loop waits for all threads, even for one that another program keeps off its core.
// threads >= 1; 0: OpenMP's own number.
[[nodiscard]] DVDX_EXPORT ParallelFor openmp(int threads = 0);

// The threads of one OpenMP region take tasks of loops until the team is destroyed. A loop waits for tasks and not for threads:
// the others take the tasks of a thread without a core. Idle threads spin for some 20 us, then sleep. One loop runs at a time;
// a second one, from another thread, runs on its caller alone.
class DVDX_EXPORT OpenMpTeam {
 public:
  // threads >= 1, including the caller of a loop; 0: OpenMP's own number. Throws std::system_error if the system has no more
  // threads.
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
