// The caller's threads.
#pragma once

#include <cstddef>

namespace dvdx {

// Runs body(task, index) for every index below count, on any threads of the caller's, and returns when all are done. body
// neither throws nor locks nor allocates. Results never depend on which thread runs which index.
struct ParallelFor {
  using Body = void (*)(void* task, std::size_t index);
  using Run = void (*)(void* context, std::size_t count, Body body, void* task);

  Run run = nullptr;  // null: the calling thread does all
  void* context = nullptr;
};

}  // namespace dvdx
