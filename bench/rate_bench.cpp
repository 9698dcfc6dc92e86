// The rate pass: making a particle's own coefficients (items are particles), and stepping with them.
#include <array>

#include "isa/passes.hpp"
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"

namespace dvdx::bench {
namespace {

// The input and output columns of the pass, for `count` particles of 1 to 2 kg.
class RateColumns {
 public:
  explicit RateColumns(std::size_t count) {
    for (auto& column : columns_) column.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double mass = 1 + static_cast<double>(i % 1009) / 1009;
      columns_[0][i] = 40 / mass;
      columns_[1][i] = 0.32 / mass;
    }
  }
  [[nodiscard]] RateRun run() {
    auto& [W, g, A, B, C, S, X] = columns_;
    return {W.size(), frame, W.data(), g.data(), A.data(), B.data(), C.data(), S.data(), X.data()};
  }
  bool operator==(const RateColumns&) const = default;

 private:
  std::array<std::vector<double>, 7> columns_;
};

void time_making(benchmark::State& timing, Isa isa, std::size_t count) {
  RateColumns columns(count), expected(count);
  const RatePass pass = find_passes(isa)->f64.free.rate;
  for (auto _ : timing) {
    pass(columns.run());
    benchmark::ClobberMemory();
  }
  timing.SetItemsProcessed(timing.iterations() * static_cast<std::int64_t>(count));
  timing.SetBytesProcessed(timing.iterations() * static_cast<std::int64_t>(count * 7 * sizeof(double)));
  find_passes(Isa::reference)->f64.free.rate(expected.run());
  if (columns != expected) timing.SkipWithError("differs from the reference");
}

void time_plain_making(benchmark::State& timing, std::size_t count) {
  RateColumns columns(count);
  const RateRun run = columns.run();
  for (auto _ : timing) {
    plain_coefficients(run.W, run.g, run.h, count, run.A, run.B, run.C);
    benchmark::ClobberMemory();
  }
  timing.SetItemsProcessed(timing.iterations() * static_cast<std::int64_t>(count));
}

template <class T>
void add_stepping(Pace pace) {
  add_in_cache<T>(pace, {.name = "rate/step", .scene = masses});
  add_plain<T>(pace, "rate/step",
               [forces = plain_meadow<T>(), mass = std::make_shared<std::vector<T>>(8'000'000, T(1.5))](
                   const PlainArrays<T>& arrays) { plain_masses_step(arrays, mass->data(), forces, static_cast<T>(frame)); });
}

}  // namespace

void register_rate(Pace pace) {
  for (const Size& size : {Size{"L1", 512}, in_second_cache(pace)}) {
    for (const Isa isa : available_isas()) {
      add(pace, "rate/make/float64/" + std::string(name(isa)) + "/separate/" + size.name + "/threads:1",
          [isa, count = size.count](benchmark::State& timing) { time_making(timing, isa, count); });
    }
    add(pace, "rate/make/float64/plain/" + size.name + "/threads:1",
        [count = size.count](benchmark::State& timing) { time_plain_making(timing, count); });
  }
  add_stepping<float>(pace);
  add_stepping<double>(pace);
}

}  // namespace dvdx::bench
