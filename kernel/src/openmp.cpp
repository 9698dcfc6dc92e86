#include "dvdx/openmp.hpp"

#include <omp.h>

#include <cstdint>

namespace dvdx {
namespace {

void run(void* context, std::size_t count, ParallelFor::Body body, void* task) {
  const auto asked = static_cast<int>(reinterpret_cast<std::intptr_t>(context));
  const int threads = asked > 0 ? asked : omp_get_max_threads();
#pragma omp parallel for num_threads(threads) schedule(static)
  for (std::size_t i = 0; i < count; ++i) body(task, i);
}

}  // namespace

ParallelFor openmp(int threads) {
  // NOLINTNEXTLINE(performance-no-int-to-ptr): a context is a pointer
  return {.run = run, .context = reinterpret_cast<void*>(static_cast<std::intptr_t>(threads))};
}

}  // namespace dvdx
