// A million particles of which a percentage dies and is born in each step, and the same without births and deaths.
#pragma once

#include <memory>

#include "dvdx/live.hpp"
#include "support/held.hpp"
#include "support/scenes.hpp"
#include "support/threads.hpp"

namespace dvdx::bench {

// A jet whose particles live for 1/share steps on average, with a spread of half of that.
inline Lifecycle jet(std::size_t count, double share, SurvivorOrder order) {
  const double life = frame / share;
  return {.emitters = {{.shape = Disc{.radius = 0.2},
                        .rate = static_cast<double>(count) * share / frame,
                        .velocity = {0, 9, 0},
                        .spread = Vec3{1, 1, 1},
                        .least_lifetime = 0.5 * life,
                        .most_lifetime = 1.5 * life,
                        .seed = 1}},
          .removal = {.order = order},
          .capacity = count + count / 10};
}

// Stepped until deaths balance births.
struct Jet {
  std::shared_ptr<LifecyclePlan<float>> plan;
  Held<float> held, lives;
  std::shared_ptr<LiveState<float>> live;
  std::size_t steps = 1;
  ParallelFor parallel{};
  void operator()() const { (void)plan->step(*live, steps, parallel); }
};

inline Jet make_jet(const Scene& scene, std::size_t count, double share, std::size_t steps, int threads, SurvivorOrder order) {
  const Lifecycle turnover = jet(count, share, order);
  auto plan = compile<float>(scene, turnover, Options{});
  if (!plan) return {};
  Jet made{.plan = std::make_shared<LifecyclePlan<float>>(std::move(*plan)),
           .held = hold_padded<float>(turnover.capacity),
           .lives = hold_padded<float>(turnover.capacity),
           .live = std::make_shared<LiveState<float>>(),
           .steps = steps,
           .parallel = on_threads(threads)};
  made.live->state = made.held.state;
  made.live->state.count = 0;
  made.live->age = made.lives.state.x[0];
  made.live->lifetime = made.lives.state.x[2];
  for (std::size_t n = 0; n < 2 * static_cast<std::size_t>(1.5 / share); ++n)
    (void)made.plan->step(*made.live, 1, made.parallel);
  return made;
}

}  // namespace dvdx::bench
