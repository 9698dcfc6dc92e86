// The block loop: time against the number of steps of a block in cache, by the batch's place in memory and by threads.
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"

namespace dvdx::bench {
namespace {

template <class T>
Case<T> meadow_case(const std::string& name, std::size_t steps) {
  return {.name = name, .scene = [](std::size_t) { return meadow(); }, .steps = steps};
}

template <class T>
void add_steps(Pace pace) {
  for (const std::size_t steps : {1U, 2U, 4U, 8U, 16U, 64U}) {
    const Case<T> work = meadow_case<T>("step/steps:" + std::to_string(steps), steps);
    for (const Size& size : {Size{"L1", in_first_cache<T>()}, in_second_cache(pace), in_memory(pace)}) {
      for (int threads = 1; threads <= most_threads(); ++threads)
        add_plan(pace, work, {best_isa(), Arithmetic::separate, threads}, size);
    }
  }
}

}  // namespace

void register_block_loop(Pace pace) {
  add_steps<float>(pace);
  add_steps<double>(pace);
}

}  // namespace dvdx::bench
