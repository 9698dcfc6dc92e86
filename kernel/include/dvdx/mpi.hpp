// Ranks of an MPI communicator: link dvdx::mpi.
#pragma once

#include <mpi.h>

#include <memory>

#include "dvdx/export.h"
#include "dvdx/ranks.hpp"

namespace dvdx {

// The communicator is the caller's, between MPI_Init and MPI_Finalize for as long as the ranks live. They talk on a copy of it,
// so that no message of the caller's is taken for one of theirs. To be made on all of its processes.
[[nodiscard]] DVDX_EXPORT std::unique_ptr<Ranks> mpi_ranks(MPI_Comm communicator);

}  // namespace dvdx
