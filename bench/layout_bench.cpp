// The same step over memory of every layout.
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"

namespace dvdx::bench {
namespace {

template <class T>
void add_layouts(Pace pace) {
  struct Layout {
    std::string name;
    Hold<T> hold;
  };
  const std::vector<Layout> layouts = {
      {"soa", hold_full<T>}, {"padded_soa", hold_padded<T>}, {"soa_pages_apart", hold_pages<T>},
      {"aos", hold_aos<T>},  {"aosoa8", hold_tiles<T, 8>},   {"aosoa16", hold_tiles<T, 16>}};
  for (const Layout& layout : layouts) {
    for (const std::size_t steps : {1U, 16U}) {
      const Case<T> work{.name = "layout/" + layout.name + "/steps:" + std::to_string(steps),
                         .scene = [](std::size_t) { return meadow(); },
                         .hold = layout.hold,
                         .steps = steps};
      for (const Size& size : {Size{"L1", in_first_cache<T>()}, in_second_cache(pace), in_memory(pace)}) {
        add_plan(pace, work, {best_isa(), Arithmetic::separate}, size);
      }
    }
  }
}

}  // namespace

void register_layout(Pace pace) {
  add_layouts<float>(pace);
  add_layouts<double>(pace);
}

}  // namespace dvdx::bench
