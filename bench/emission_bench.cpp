// The emission pass: particles born per second, on a disc and with a spread.
#include <memory>

#include "isa/passes.hpp"
#include "support/benches.hpp"
#include "support/plan_bench.hpp"

namespace dvdx::bench {
namespace {

void time_emission(benchmark::State& timing, Isa isa) {
  EmissionTerms terms;
  terms.shape = EmissionShape::disc;
  terms.spread = EmissionSpread::ball;
  terms.radii = {Vec3{1, 0, 0}, Vec3{0, 1, 0}};
  terms.radius = 1;
  terms.lifetime = terms.lifetime_range = 1;
  terms.interval = 1e-3;
  const auto born = std::make_unique<Born>();
  Births births{.first = 0, .count = born_together, .lead = born_together, .step = 1};
  for (auto _ : timing) {
    find_passes(isa)->emit(terms, births, *born);
    benchmark::ClobberMemory();
    births.first += born_together;
  }
  timing.SetItemsProcessed(static_cast<std::int64_t>(timing.iterations()) * static_cast<std::int64_t>(born_together));
}

}  // namespace

void register_emission(Pace pace) {
  for (const Isa isa : available_isas()) {
    add(pace, "emission/disc_and_ball/" + std::string(name(isa)),
        [=](benchmark::State& timing) { time_emission(timing, isa); });
  }
}

}  // namespace dvdx::bench
