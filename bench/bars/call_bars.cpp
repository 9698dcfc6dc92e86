// The cost of a call by itself, births and removals, and calls through C.
#include <array>
#include <cstdlib>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bars/bars.hpp"
#include "dvdx/dvdx.h"
#include "dvdx/plan.hpp"
#include "support/held.hpp"
#include "support/race.hpp"
#include "support/report.hpp"
#include "support/scenes.hpp"
#include "support/threads.hpp"
#include "support/turnover.hpp"

namespace dvdx::bench {
namespace {

// Gravity and drag through C's functions, over the caller's arrays.
class SteppedByC {
 public:
  SteppedByC(float* const (&columns)[6], std::size_t count, int threads)
      : threads_(on_threads(threads)), parallel_{threads_.run, threads_.context} {
    dvdx_scene* scene = nullptr;
    dvdx_constant gravity{};
    gravity.acceleration[1] = -9.81;
    dvdx_drag air{};
    air.coefficient.all = 0.02;
    air.wind[0] = 3;
    dvdx_options options{};
    options.step = frame;
    dvdx_plan* plan = nullptr;
    const bool is_made = dvdx_scene_create(DVDX_ABI_VERSION, &scene, nullptr) == DVDX_DONE &&
                         dvdx_scene_add_constant(scene, &gravity, nullptr) == DVDX_DONE &&
                         dvdx_scene_add_drag(scene, &air, nullptr) == DVDX_DONE &&
                         dvdx_plan_create(scene, &options, nullptr, &plan, nullptr) == DVDX_DONE;
    dvdx_scene_destroy(scene);
    if (!is_made) std::exit(1);
    plan_ = {plan, dvdx_plan_destroy};
    state_ = dvdx_soa(DVDX_FLOAT32, columns[0], columns[1], columns[2], columns[3], columns[4], columns[5], count);
  }
  void operator()() { dvdx_plan_step(plan_.get(), &state_, 1, parallel_.run == nullptr ? nullptr : &parallel_, &error_); }

 private:
  std::shared_ptr<dvdx_plan> plan_;
  dvdx_state state_{};
  dvdx_error error_{};
  ParallelFor threads_;
  dvdx_parallel parallel_;
};

}  // namespace

void overheads(Report& report, const Run& run, const Held<float>& held) {
  const Held<float> small = scattered<float>(in_cache);
  const Race race = bench::race(run.effort, stepper(meadow(), small, 1), stepper(meadow(), small, 64));
  report.figure("what a call costs besides its steps, 1024 particles", (race.a - race.b / 64) * 1e9, "ns");
  report.figure("a call of no steps", shortest(run.effort, stepper(meadow(), small, 0)) * 1e9, "ns");
  report.figure("a call for 16 particles", shortest(run.effort, stepper(meadow(), scattered<float>(16), 1)) * 1e9, "ns");
  auto plan = make_plan<float>(meadow());
  report.figure("set_step", shortest(run.effort, [&] { static_cast<void>(plan.set_step(frame)); }) * 1e9, "ns",
                "coefficients made anew");
  const Held<float> fresh = scattered<float>(in_cache);
  auto state = fresh.state;
  report.figure("seek an hour, a particle",
                shortest(run.effort, [&] { static_cast<void>(plan.seek(state, 216000)); }) * 1e9 / in_cache, "ns",
                "1024 particles, 216000 steps");

  struct Kind {
    std::string name;
    Scene scene;
  };
  for (const Kind& kind : {Kind{"drift", fall()}, Kind{"fused", meadow()}, Kind{"driven_fused", gusts()},
                           Kind{"shear", swing()}, Kind{"radial", ring()}}) {
    const double once = shortest(run.memory_effort, stepper(kind.scene, held, 1)) / in_memory;
    const double often = shortest(run.effort, stepper(kind.scene, small, 16)) / (16 * in_cache);
    report.figure(kind.name + ", 8 million", once * 1e9, "ns", "a particle and step");
    report.figure(kind.name + ", L1, 16 steps a call", often * 1e9, "ns", "a particle and step");
  }
}

// One step a call: more steps a call leave the particles in cache, and births then dominate the work.
void turnover(Report& report, const Run& run) {
  constexpr std::size_t million = 1'000'000;
  for (const auto& [name, scene] :
       {std::pair{"falling", fall()}, std::pair{"with a floor to look for", with(fall(), far_floor({0, 1, 0}))}}) {
    for (int threads = 1; threads <= most_threads(); ++threads) {
      const Jet jet = make_jet(scene, million, 0.02, 1, threads, SurvivorOrder::kept);
      const Jet in_any_order = make_jet(scene, million, 0.02, 1, threads, SurvivorOrder::any);
      Held<float> same = hold_padded<float>(million);  // a copy of the jet, so that as many particles touch the ground
      for (std::size_t i = 0; i < million; ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          same.state.x[axis][i] = jet.live->state.x[axis][i % jet.live->state.count];
          same.state.v[axis][i] = jet.live->state.v[axis][i % jet.live->state.count];
        }
      }
      const auto stays = stepper(scene, same, 1, threads);
      const std::string how = std::string(name) + ", " + std::to_string(threads) + " thread" + (threads > 1 ? "s" : "");
      const Race race = bench::race(run.in_memory_on(threads), jet, stays);
      report.bar("2 % of a million come and go each step, " + how + " / none do", {.at_least = false, .bound = 1.5}, race,
                 against(race, million, million));
      const Race any = bench::race(run.in_memory_on(threads), in_any_order, stays);
      report.bar("2 % of a million come and go each step, in any order, " + how + " / none do",
                 {.at_least = false, .bound = 1.3}, any, against(any, million, million));
    }
  }
}

void c_api(Report& report, const Run& run) {
  constexpr std::size_t million = 1'000'000;
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}}).add(Drag{.coefficient = 0.02, .wind = {3, 0, 0}});
  const Held<float> ours = scattered<float>(million);
  std::array<std::vector<float>, 6> theirs;
  for (std::size_t k = 0; k < 6; ++k) {
    const Column<float>& from = k < 3 ? ours.state.x[k] : ours.state.v[k - 3];
    theirs[k].assign(from.base, from.base + million);
  }
  for (int threads = 1; threads <= most_threads(); ++threads) {
    const auto by_cpp = stepper(scene, ours, 1, threads);
    const auto bar = [&](const std::string& whose, float* const(&columns)[6]) {
      const Race race = bench::race(run.in_memory_on(threads), SteppedByC(columns, million, threads), by_cpp);
      report.bar("a million by C in " + whose + " / by C++ in our buffers" + threads_of(threads), {false, 1.02}, race,
                 against(race, million, million));
    };
    bar("six vectors",
        {theirs[0].data(), theirs[1].data(), theirs[2].data(), theirs[3].data(), theirs[4].data(), theirs[5].data()});
    const auto& [x, v] = std::tie(ours.state.x, ours.state.v);
    bar("the same buffers", {x[0].base, x[1].base, x[2].base, v[0].base, v[1].base, v[2].base});
  }
}

}  // namespace dvdx::bench
