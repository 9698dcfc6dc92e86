// The removal pass in cache, and the cost of births and removals in a step of a million particles.
#include <array>

#include "isa/passes.hpp"
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/turnover.hpp"

namespace dvdx::bench {
namespace {

constexpr std::size_t in_cache = 1024;

Size many(Pace pace) { return pace == Pace::timed ? Size{"million", 1'000'000} : Size{"thousands", 20'000}; }

// Eight columns of 4 bytes, every n-th particle removed. The copy goes elsewhere, so that each turn has the same work.
void time_compaction(benchmark::State& timing, Isa isa, std::size_t every) {
  std::vector<std::uint64_t> removed(in_cache / 64);
  for (std::size_t i = 0; i < in_cache; i += every) removed[i / 64] |= std::uint64_t{1} << (i % 64);
  std::array<std::vector<std::uint32_t>, compact_columns> from, to;
  std::array<const std::byte*, compact_columns> in{};
  std::array<std::byte*, compact_columns> out{};
  for (std::size_t c = 0; c < compact_columns; ++c) {
    from[c].assign(in_cache, static_cast<std::uint32_t>(c));
    to[c].assign(in_cache, 0);
    in[c] = reinterpret_cast<const std::byte*>(from[c].data());
    out[c] = reinterpret_cast<std::byte*>(to[c].data());
  }
  const Compact compact = find_passes(isa)->compact4;
  for (auto _ : timing) {
    benchmark::DoNotOptimize(compact(in.data(), out.data(), compact_columns, removed.data(), in_cache));
    benchmark::ClobberMemory();
  }
  timing.SetItemsProcessed(static_cast<std::int64_t>(timing.iterations()) * static_cast<std::int64_t>(in_cache));
}

void time_jet(benchmark::State& timing, const Scene& scene, std::size_t count, std::size_t steps, int threads,
              SurvivorOrder order) {
  const Jet made = make_jet(scene, count, 0.02, steps, threads, order);
  if (made.plan == nullptr) return timing.SkipWithError("no plan");
  for (auto _ : timing) made();
  count_work<float>(timing, count, steps);
}

void add_jet(Pace pace, const std::string& name, const Scene& scene) {
  const Size size = many(pace);
  for (const std::size_t steps : {std::size_t{1}, std::size_t{8}}) {
    const Case<float> stays{.name = "turnover/" + name + "/none/steps:" + std::to_string(steps),
                            .scene = [scene](std::size_t) { return scene; },
                            .steps = steps};
    for (int threads = 1; threads <= most_threads(); ++threads) {
      add_plan(pace, stays, {best_isa(), Arithmetic::separate, threads}, size);
      for (const auto& [order_name, order] :
           {std::pair{"2%", SurvivorOrder::kept}, std::pair{"2%_any_order", SurvivorOrder::any}}) {
        add(
            pace,
            "turnover/" + name + "/" + order_name + "/steps:" + std::to_string(steps) + "/" + size.name +
                "/threads:" + std::to_string(threads),
            [=, order = order](benchmark::State& timing) { time_jet(timing, scene, size.count, steps, threads, order); },
            threads);
      }
    }
  }
}

}  // namespace

void register_removal(Pace pace) {
  for (const Isa isa : available_isas()) {
    const std::string isa_name(name(isa));
    for (const std::size_t every : {std::size_t{2}, std::size_t{50}}) {
      add(pace, "removal/eight_columns/1_in_" + std::to_string(every) + "/" + isa_name,
          [=](benchmark::State& timing) { time_compaction(timing, isa, every); });
    }
  }
  add_jet(pace, "fall", fall());
  add_jet(pace, "fall_with_far_floor", with(fall(), far_floor({0, 1, 0})));
}

}  // namespace dvdx::bench
