// The ranks that the command was started as.
#pragma once

#include <memory>

#include "dvdx/ranks.hpp"

namespace dvdx::tool {

struct Joined {
  std::unique_ptr<Ranks> ranks;  // never null
  bool by_launcher = false;      // mpirun, srun or the like started this process
};

// One rank by itself where nothing says that a launcher of MPI programs started the process: MPI is then neither loaded nor
// initialised. Throws Fault (usage) where one started it as one of several, and this build has no MPI.
[[nodiscard]] Joined join_ranks();

// As how many ranks a launcher started the command: 1 where none did.
[[nodiscard]] int ranks_started();

// The number of ranks on this machine, which share its cores.
[[nodiscard]] int ranks_here();

}  // namespace dvdx::tool
