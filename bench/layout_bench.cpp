// The same step on every memory layout.
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"
#include "support/structs.hpp"

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

// Plain loops over the same structs, compiled for this machine and for any of its architecture.
void add_plain_structs(Pace pace) {
  for (std::size_t k = 0; k < struct_shapes.size(); ++k) {
    for (const auto& [machine, step_of] :
         {std::pair{"native", &plain_struct_step_native}, std::pair{"any", &plain_struct_step_any}}) {
      for (const Size& size : {Size{"L1", in_first_cache<float>()}, in_second_cache(pace), in_memory(pace)}) {
        const auto time = [step = step_of(k, Flies::free), k, count = size.count](benchmark::State& timing) {
          const Held<float> held = hold_structs(struct_shapes[k], count);
          const PlainFlow flow{0, 3e-4F, 0, 0.0166F, {0, -0.16F, 0}, {0, -1.4e-3F, 0}};
          for (auto _ : timing) {
            step(held.state.x[0].base, held.state.v[0].base, count, flow);
            benchmark::ClobberMemory();
          }
          count_work<float>(timing, count, 1);
        };
        add(pace, "layout/" + struct_shapes[k].name + "/plain_" + machine + "/" + size.name + "/threads:1", time);
      }
    }
  }
}

template <std::size_t shape>
Held<float> hold_shape(std::size_t count) {
  return hold_structs(struct_shapes[shape], count);
}

// Gravity and drag, one step a call, on every instruction set.
template <std::size_t... shape>
void add_structs(Pace pace, std::index_sequence<shape...>) {
  const std::array<Hold<float>, sizeof...(shape)> holds{hold_shape<shape>...};
  for (std::size_t k = 0; k < holds.size(); ++k) {
    const Case<float> work{
        .name = "layout/" + struct_shapes[k].name, .scene = [](std::size_t) { return fall(); }, .hold = holds[k]};
    add_in_cache(pace, work);
    add_in_memory(pace, work);
  }
}

}  // namespace

void register_layout(Pace pace) {
  add_layouts<float>(pace);
  add_layouts<double>(pace);
  add_plain_structs(pace);
  add_structs(pace, std::make_index_sequence<struct_shapes.size()>());
}

}  // namespace dvdx::bench
