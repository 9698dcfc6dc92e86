// Work on particles, shared among the threads of a run.
#pragma once

#include <algorithm>
#include <cstddef>

#include "dvdx/parallel.hpp"

namespace dvdx::tool {

inline constexpr std::size_t most_slices = 64;

// Calls use(slice, first, end) for slices of the particles below count, in sequence or in parallel. use must not throw. The
// slices depend on count alone.
template <class Use>
void for_each_slice(const ParallelFor& parallel, std::size_t count, const Use& use) {
  constexpr std::size_t least = std::size_t{1} << 14U;  // below it threads cost more than they save
  struct Task {
    const Use& use;
    std::size_t count, each;
  };
  const Task task{use, count, std::max(least, (count + most_slices - 1) / most_slices)};
  const auto body = [](void* context, std::size_t slice) {
    const Task& of = *static_cast<const Task*>(context);
    of.use(slice, slice * of.each, std::min(of.count, (slice + 1) * of.each));
  };
  const std::size_t slices = (count + task.each - 1) / task.each;
  auto* const context = const_cast<Task*>(&task);  // the callback takes a void*; nothing writes to it
  if (parallel.run != nullptr) return parallel.run(parallel.context, slices, body, context);
  for (std::size_t slice = 0; slice < slices; ++slice) body(context, slice);
}

}  // namespace dvdx::tool
