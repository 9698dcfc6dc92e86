// Ranks of an MPI communicator: link dvdx::mpi.
#pragma once

#include <mpi.h>

#include <memory>

#include "dvdx/export.h"
#include "dvdx/ranks.hpp"

namespace dvdx {

// Makes ranks from the caller's communicator. Call it on all of its processes. MPI must be initialised as long as the ranks
// live. They send on a copy of the communicator, so that no message of the caller's is taken for one of theirs.
[[nodiscard]] DVDX_EXPORT std::unique_ptr<Ranks> mpi_ranks(MPI_Comm communicator);

}  // namespace dvdx
