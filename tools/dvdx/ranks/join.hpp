// The ranks that the command was started as.
#pragma once

#include <memory>

#include "dvdx/ranks.hpp"

namespace dvdx::tool {

struct Joined {
  std::unique_ptr<Ranks> ranks;  // never null
  bool by_launcher = false;      // mpirun, srun or the like started this process
};

// Returns one rank alone unless a launcher of MPI programs started the process: MPI is then neither loaded nor initialised.
// Throws Fault (usage) if a launcher started it as one of several and this build has no MPI or cannot load it.
[[nodiscard]] Joined join_ranks();

// Returns the number of ranks that a launcher started, or 1 if none did.
[[nodiscard]] int ranks_started();

// The number of ranks on this machine, which share its cores.
[[nodiscard]] int ranks_here();

}  // namespace dvdx::tool
