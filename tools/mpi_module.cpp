// The part of the command that needs MPI: loaded by ranks/join.cpp where a launcher started the process.
#include <cstdlib>

#include "dvdx/mpi.hpp"

// To be called once, by one thread. The ranks are the caller's to delete before the process ends, which ends MPI.
extern "C" DVDX_EXPORT dvdx::Ranks* dvdx_start_ranks() {
  int provided = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);  // threads of the steps do not talk
  std::atexit([] { MPI_Finalize(); });
  return dvdx::mpi_ranks(MPI_COMM_WORLD).release();
}
