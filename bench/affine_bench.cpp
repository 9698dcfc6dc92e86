// The affine pass by flow: six columns read and written, at most 4 multiply-adds an axis.
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"

namespace dvdx::bench {
namespace {

template <class T>
void time_structs(benchmark::State& timing, std::size_t count) {
  std::vector<PlainParticle<T>> particles(count);
  for (std::size_t i = 0; i < count; ++i) particles[i] = {{T(0.1), T(0.2), static_cast<T>(i % 7)}, {T(1), T(0), T(-1)}, T(1)};
  const PlainForces<T> forces = plain_meadow<T>();
  for (auto _ : timing) {
    plain_aos_step(particles, forces, static_cast<T>(frame));
    benchmark::ClobberMemory();
  }
  count_work<T>(timing, count, 1);
}

template <class T>
void time_scaling(benchmark::State& timing, std::size_t count) {
  time_plain<T>(timing, count, scatter_about<T>,
                [](const PlainArrays<T>& arrays) { scale_in_place(arrays, T(1), 0, arrays.count); });
}

template <class T>
void add_flows(Pace pace) {
  const auto uniform = [](Scene (*scene)()) { return [scene](std::size_t) { return scene(); }; };
  add_everywhere<T>(pace, {.name = "affine/drift", .scene = uniform(fall)});
  add_everywhere<T>(pace, {.name = "affine/fused", .scene = uniform(meadow)});
  add_everywhere<T>(pace, {.name = "affine/driven_fused", .scene = uniform(gusts)});
  add_everywhere<T>(pace, {.name = "affine/shear", .scene = uniform(swing)});  // fused in float64
  add_in_cache<T>(pace, {.name = "affine/driven_fused_each", .scene = uniform(stalks)});

  add_plain<T>(pace, "affine/fused", [forces = plain_meadow<T>()](const PlainArrays<T>& arrays) {
    plain_soa_step(arrays, T(1), forces, static_cast<T>(frame));
  });
  for (const Size& size : {Size{"L1", in_first_cache<T>()}, in_second_cache(pace), in_memory(pace)}) {
    const std::string end = "/" + size.name + "/threads:1";
    add(pace, "affine/fused/" + scalar_name<T>() + "/plain_structs" + end,
        [count = size.count](benchmark::State& timing) { time_structs<T>(timing, count); });
    add(pace, "affine/scaling/" + scalar_name<T>() + "/plain" + end,
        [count = size.count](benchmark::State& timing) { time_scaling<T>(timing, count); });
  }
}

}  // namespace

void register_affine(Pace pace) {
  add_flows<float>(pace);
  add_flows<double>(pace);
}

}  // namespace dvdx::bench
