// Each rank steps a range of the particles; from rank to rank their hash becomes that of all.
#include <cstdio>
#include <dvdx/layouts/soa.hpp>
#include <dvdx/layouts/state_hash.hpp>
#include <dvdx/mpi.hpp>
#include <dvdx/plan.hpp>

// The hash goes on from `before`, after 50 steps of particles first, first + 1, ...
std::uint64_t stepped(std::size_t first, std::size_t count, std::uint64_t before) {
  dvdx::Soa<float> memory(count);
  auto state = memory.view();
  for (std::size_t i = 0; i < count; ++i) state.x[1][i] = static_cast<float>(first + i);
  dvdx::Scene scene;
  scene.add(dvdx::Constant{.acceleration = {0, -9.81, 0}});
  const auto plan = dvdx::compile<float>(scene, {.step = 0.01});
  if (!plan || plan->step(state, 50) != dvdx::StepResult::done) return 0;
  return dvdx::state_hash(state, before);
}

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  bool is_same = false;
  {
    const auto ranks = dvdx::mpi_ranks(MPI_COMM_WORLD);
    const auto rank = static_cast<std::size_t>(ranks->rank());
    std::uint64_t hash = dvdx::empty_state_hash;
    if (rank > 0) ranks->receive(ranks->rank() - 1, dvdx::writable_bytes_in(hash));
    hash = stepped(100 * rank, 100, hash);
    if (ranks->rank() + 1 < ranks->count()) ranks->send(ranks->rank() + 1, dvdx::bytes_in(hash));
    ranks->broadcast(ranks->count() - 1, dvdx::writable_bytes_in(hash));
    is_same = hash == stepped(0, 100 * static_cast<std::size_t>(ranks->count()), dvdx::empty_state_hash);
    if (rank == 0) std::printf("on %d ranks: %s\n", ranks->count(), is_same ? "the bits of one" : "other bits");
  }
  MPI_Finalize();
  return is_same ? 0 : 1;
}
