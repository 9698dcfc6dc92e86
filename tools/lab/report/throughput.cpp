#include "report/throughput.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "report/grid.hpp"
#include "report/sample.hpp"
#include "report/stopwatch.hpp"
#include "scene_io/names.hpp"
#include "state/origin.hpp"

namespace dvdx::tool::report {
namespace {

constexpr std::uint64_t many_steps = 16;

struct Sizes {
  std::size_t fewest, factor, most;
  double seconds;  // after this time no larger count is begun
};

Sizes sizes_for(Effort effort) {
  if (effort == Effort::quick) return {.fewest = 256, .factor = 16, .most = 65536, .seconds = 0.2};
  return {.fewest = 256, .factor = 4, .most = std::size_t{1} << 22U, .seconds = 0.6};
}

template <class T>
class Stepped {
 public:
  Stepped(const SceneFile& file, const Setup& setup)
      : setup_(setup),
        scene_steps_(steps_of(file)),
        start_(setup.engine.layout, file.particles.count, rounding_of(setup.engine.precision)),
        work_(setup.engine.layout, file.particles.count, rounding_of(setup.engine.precision)),
        state_(placed(file, start_)),
        plan_(compiled(file, file.scene, file.step, setup.engine, state_)) {}

  // A repeat takes about two milliseconds from the start, or one call. It stays near the start: later steps may cost more.
  [[nodiscard]] Throughput measured(std::uint64_t steps_per_call) {
    constexpr double enough = 2e-3;  // s
    auto work = work_.view();
    const auto prepare = [&] { copy_state(state_, work); };
    const auto run = [&](std::uint64_t calls) {
      for (std::uint64_t call = 0; call < calls; ++call) advance(plan_, work, steps_per_call, setup_.parallel);
    };
    prepare();
    const auto before = std::chrono::steady_clock::now();
    run(1);  // warm-up
    const double spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
    const auto most = std::max<std::uint64_t>(1, std::min(scene_steps_, 4 * many_steps) / steps_per_call);
    const auto calls = static_cast<std::uint64_t>(std::clamp(enough / spent, 1.0, static_cast<double>(most)));
    const auto least = least_of(prepare, [&] { run(calls); });
    const auto columns = static_cast<std::size_t>(state_.has_rests() ? 12 : 6);
    return {.precision = setup_.engine.precision,
            .particles = state_.count,
            .state_bytes = columns * sizeof(T) * state_.count,
            .steps_per_call = steps_per_call,
            .ns_per_particle_step = 1e9 * least.seconds / static_cast<double>(calls * steps_per_call * state_.count),
            .repeats = least.repeats};
  }

 private:
  static State<T> placed(const SceneFile& file, StateMemory<T>& memory) {
    auto state = memory.view();
    place_at_start(file, state);
    return state;
  }

  const Setup& setup_;
  std::uint64_t scene_steps_;
  StateMemory<T> start_;
  StateMemory<T> work_;
  State<T> state_;  // the start
  Plan<T> plan_;
};

}  // namespace

std::vector<Throughput> measure_throughput(const SceneFile& file, const MeasureOptions& options, const Setup& setup,
                                           const ProgressCallback& progress) {
  const auto sizes = sizes_for(options.effort);
  std::vector<Throughput> found;
  for (const auto precision : options.precisions) {
    auto engine_setup = setup;
    engine_setup.engine.precision = precision;
    const auto before = std::chrono::steady_clock::now();
    const auto is_time_left = [&] {
      return std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count() < sizes.seconds;
    };
    const auto second = sizes.fewest * sizes.factor;
    for (auto count = sizes.fewest; count <= sizes.most && (count <= second || is_time_left()); count *= sizes.factor) {
      progress(1, fmt::format("{} throughput of {} particles", name_in(precisions, precision), count));
      auto sized = resized(file, count);
      choose_origin(sized, precision);
      with_scalar(precision, [&](auto zero) {
        Stepped<decltype(zero)> stepped(sized, engine_setup);
        for (const auto steps : {std::uint64_t{1}, many_steps}) found.push_back(stepped.measured(steps));
      });
    }
  }
  return found;
}

}  // namespace dvdx::tool::report
