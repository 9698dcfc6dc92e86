// Sheets: a hundred of them, the cost of a moving world, and the cost of air.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bars/bars.hpp"
#include "dvdx/plan.hpp"
#include "support/held.hpp"
#include "support/race.hpp"
#include "support/report.hpp"
#include "support/scenes.hpp"
#include "support/starts.hpp"
#include "support/threads.hpp"

namespace dvdx::bench {
namespace {

// Copies of one sheet in one plan, or the same number of states of one plan.
struct Sheets {
  static constexpr std::size_t many = 100;

  static Stepper<float> in_one_plan(Scheme scheme) {
    const Scene one = hung_sheet(scheme);
    const Held<float> start = hung();
    const std::size_t count = start.state.count;
    Scene all = one;
    all.networks.clear();
    all.fixed.clear();
    const Held<float> held = hold_padded<float>(many * count);
    for (std::size_t sheet = 0; sheet < many; ++sheet) {
      Grid grid = std::get<Grid>(one.networks[0]);
      grid.first = sheet * count;
      all.networks.emplace_back(grid);
      for (const std::size_t particle : one.fixed) all.fixed.push_back(grid.first + particle);
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          held.state.x[axis][grid.first + i] = start.state.x[axis][i];
          held.state.v[axis][grid.first + i] = 0;
        }
      }
    }
    return joined_stepper(std::move(all), held);
  }
  static Stepper<float> alone(Scheme scheme) { return joined_stepper(hung_sheet(scheme), hung()); }
};

// Clones of a plan, each with its own state, over threads.
class States {
 public:
  States(const Stepper<float>& one, int threads) : parallel_(on_threads(threads)) {
    for (std::size_t n = 0; n < Sheets::many; ++n) {
      states_->push_back({std::make_shared<Plan<float>>(one.plan->clone()), hung()});
    }
  }
  void operator()() {
    if (parallel_.run == nullptr) {
      for (Stepper<float>& state : *states_) state();
    } else {
      parallel_.run(parallel_.context, states_->size(), step, states_.get());
    }
  }

 private:
  static void step(void* states, std::size_t n) { (*static_cast<std::vector<Stepper<float>>*>(states))[n](); }

  ParallelFor parallel_;
  std::shared_ptr<std::vector<Stepper<float>>> states_ = std::make_shared<std::vector<Stepper<float>>>();
};

}  // namespace

// Steps the particles held by a scene whose networks join them.
Stepper<float> joined_stepper(Scene scene, const Held<float>& held) {
  constexpr double short_frame = 1.0 / 480;  // s: leapfrog is stable in 5 sub-steps
  scene.coupling.substeps = 5;
  auto plan = compile<float>(scene, {.step = short_frame}, held.state);
  if (!plan) {
    std::fprintf(stderr, "%s\n", plan.error().message().c_str());
    std::exit(1);
  }
  return {std::make_shared<Plan<float>>(std::move(*plan)), held};
}

void hundred_sheets(Report& report, const Run& run) {
  for (const auto& [name, scheme] : {std::pair{"leapfrog", Scheme::leapfrog}, std::pair{"sequential", Scheme::sequential}}) {
    const Stepper<float> alone = Sheets::alone(scheme);
    constexpr auto many = static_cast<double>(Sheets::many);
    const auto bar = [&](const std::string& what, const Race& race, double sheets) {
      std::array<char, 96> note{};
      std::snprintf(note.data(), note.size(), "%.1f against %.1f us", race.a * 1e6 / sheets, race.b * 1e6);
      report.bar(std::string(name) + ": a sheet of " + what + " / one alone", {false, 1.1}, times(race, 1 / sheets),
                 note.data());
    };
    bar("100 grids of a plan", bench::race(run.in_memory_on(1), Sheets::in_one_plan(scheme), alone), many);
    for (int threads = 1; threads <= most_threads(); ++threads) {
      const Race race = bench::race(run.in_memory_on(threads), States(alone, threads), alone);
      bar("100 states" + threads_of(threads), race, many / threads);
    }
  }
}

// The cost that each feature adds to a sheet's step.
void moving_world(Report& report, const Run& run) {
  const Scene plain = hung_sheet(Scheme::leapfrog);
  const auto bar = [&](const std::string& name, double bound, const Scene& with, const Scene& without) {
    report.bar(name, {false, bound}, bench::race(run.effort, joined_stepper(with, hung()), joined_stepper(without, hung())),
               "");
  };
  Scene among = plain;
  Scene falling = fall();
  for (int k = 0; k < 64; ++k) {
    const Vec3 end{0.25 * k, -1e3, -20};
    const Capsule capsule{.ends = {{end, {end[0], -1e3, 20}}}, .radius = {0.1, 0.1}, .restitution = 0.5};
    among.add(capsule);
    falling.add(capsule);
  }
  bar("a sheet, 64 capsules far away / none", 1.1, among, plain);
  const Held<float> many = scattered<float>(in_second_cache);
  const Race race = bench::race(run.effort, stepper(falling, many, 1), stepper(fall(), many, 1));
  report.bar("16384 free particles, 64 capsules far away / none", {false, 1.1}, race,
             against(race, in_second_cache, in_second_cache));
  for (const double damping : {0.0, 0.001}) {
    Scene still = plain;
    std::get<Grid>(still.networks[0]).damping = damping;
    Scene blown = still;
    std::get<Grid>(blown.networks[0]).aerodynamics = Aerodynamics{.density = 1.2, .drag = 1, .lift = 1};
    bar(damping == 0 ? "a sheet in air / none" : "a damped sheet in air / none", 1.5, blown, still);
  }
}

}  // namespace dvdx::bench
