// Particles that meet: a settled pile of grains by sub-step, the pairs' rounds, and the building of its lists.
#include <cstdint>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "passes/meet/lists.hpp"
#include "passes/meet/meet.inl.hpp"
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"

namespace dvdx::bench {
namespace {

constexpr double d = 0.02;  // m

Size heaped(Pace pace) { return pace == Pace::timed ? Size{"10000", 10000} : Size{"500", 500}; }

// Layer on layer, a little out of line, in a box as wide as it is high.
Held<float> heap(std::size_t count, std::size_t side) {
  Held<float> held = hold_padded<float>(count);
  scatter_about(held.state);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at[] = {i % side, i / (side * side), i / side % side};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double out_of_line = 0.02 * double{held.state.x[axis][i]};
      held.state.x[axis][i] = static_cast<float>((1.05 * static_cast<double>(at[axis]) + 0.55 + out_of_line) * d);
      held.state.v[axis][i] = 0;
    }
  }
  return held;
}

std::size_t side_of(std::size_t count) {
  std::size_t side = 1;
  while (side * side * side < count) ++side;
  return side;
}

Scene grains(std::size_t side) {
  const double wide = 1.05 * d * static_cast<double>(side);
  Scene scene;
  scene.add(Constant{.acceleration = {0, -9.81, 0}});
  scene.add(Contact{Plane{.friction = 0.5}});
  scene.add(Contact{Plane{.normal = {1, 0, 0}, .friction = 0.5}});
  scene.add(Contact{Plane{.normal = {-1, 0, 0}, .offset = -wide, .friction = 0.5}});
  scene.add(Contact{Plane{.normal = {0, 0, 1}, .friction = 0.5}});
  scene.add(Contact{Plane{.normal = {0, 0, -1}, .offset = -wide, .friction = 0.5}});
  scene.add(Meet{.radius = 0.5 * d, .friction = 0.5});
  return scene;
}

void time_pile(benchmark::State& timing, std::size_t count, std::size_t settled, int threads) {
  const std::size_t side = side_of(count);
  Held<float> held = heap(count, side);
  const auto plan = compile<float>(grains(side), {.step = frame}, held.state);
  if (!plan) return timing.SkipWithError(plan.error().message().c_str());
  (void)plan->step(held.state, settled);
  const std::uint64_t before = plan->meetings().substeps;
  const ParallelFor parallel = on_threads(threads);
  for (auto _ : timing) (void)plan->step(held.state, 1, parallel);
  const Meetings met = plan->meetings();
  const auto substeps = static_cast<double>(met.substeps - before);
  const double of_grains = substeps * static_cast<double>(count);
  using benchmark::Counter;
  timing.SetItemsProcessed(static_cast<std::int64_t>(of_grains));
  timing.counters["grain"] = Counter(of_grains, Counter::kIsRate | Counter::kInvert);
  timing.counters["pair"] = Counter(of_grains * met.listed / 2, Counter::kIsRate | Counter::kInvert);
  Held<float> expected = heap(count, side);
  const auto alone = compile<float>(grains(side), {.step = frame}, expected.state);
  Held<float> same = heap(count, side);
  (void)alone->step(expected.state, 2);
  const auto together = compile<float>(grains(side), {.step = frame, .isa = Isa::reference}, same.state);
  (void)together->step(same.state, 2, parallel);
  if (!is_same_bits(same.state, expected.state, count)) timing.SkipWithError("differs from the reference");
}

// The pile's lists, with a reach of a fifth of a grain.
void time_lists(benchmark::State& timing, std::size_t count, std::size_t settled) {
  const std::size_t side = side_of(count);
  Held<float> held = heap(count, side);
  const auto plan = compile<float>(grains(side), {.step = frame}, held.state);
  if (!plan) return timing.SkipWithError(plan.error().message().c_str());
  (void)plan->step(held.state, settled);
  std::vector<Point<float>> x(count);
  for (std::size_t i = 0; i < count; ++i) x[i] = {held.state.x[0][i], held.state.x[1][i], held.state.x[2][i]};
  const auto r = static_cast<float>(0.5 * d);
  const std::vector<float> a(count, r);
  PairLists<float> lists(count, 24 * count);
  const auto all = [](std::uint32_t, std::uint32_t) { return true; };
  for (auto _ : timing) {
    if (lists.build(x.data(), a.data(), 1.15F * r, 0.4F * r, all) != PairLists<float>::Found::all) {
      return timing.SkipWithError("too many");
    }
    benchmark::ClobberMemory();
  }
  timing.SetItemsProcessed(static_cast<std::int64_t>(timing.iterations()) * static_cast<std::int64_t>(count));
}

// Pairs that press on each other, in cache.
struct Pressed {
  static constexpr std::size_t count = 64;  // of lanes
  std::vector<Separations<float>> contacts{count};
  std::vector<PulseLanes<float>> pulses{count};
  Separations<float>::Three moved{};
  Separations<float>::Lanes w{};

  Pressed() {
    w.fill(6);
    for (std::size_t n = 0; n < count; ++n) {
      for (std::size_t k = 0; k < meeting_lanes; ++k) {
        Separation<float> contact;
        contact.n = {0, 1, 0};
        contact.gap = -1e-4F * static_cast<float>(1 + (n + 7 * k) % 13);
        contact.slip = {1e-4F * static_cast<float>(k), 0, 0};
        contacts[n].put(k, contact);
        pulses[n].put(k, {{}, 1});
      }
    }
  }
};

enum class By { lanes, one };

void time_round(benchmark::State& timing, By by) {
  Pressed pressed;
  for (auto _ : timing) {
    for (std::size_t n = 0; n < Pressed::count; ++n) {
      if (by == By::lanes) {
        push_lanes(pressed.contacts[n], pressed.pulses[n], pressed.moved, pressed.w, 0.5F, 0.5F);
        continue;
      }
      for (std::size_t k = 0; k < meeting_lanes; ++k) {
        Separation<float> contact = pressed.contacts[n].of(k);
        Pulse<float> pulse = pressed.pulses[n].of(k);
        push(contact, pulse, Point<float>{}, pressed.w[k], 0.5F, 0.5F);
        benchmark::DoNotOptimize(pulse);
        pressed.contacts[n].put(k, contact);
        pressed.pulses[n].put(k, pulse);
      }
    }
    benchmark::ClobberMemory();
  }
  timing.SetItemsProcessed(static_cast<std::int64_t>(timing.iterations()) *
                           static_cast<std::int64_t>(Pressed::count * meeting_lanes));
}

}  // namespace

void register_meet(Pace pace) {
  const Size size = heaped(pace);
  const std::size_t settled = pace == Pace::timed ? 60 : 2;
  for (int threads = 1; threads <= most_threads(); ++threads) {
    add(
        pace, "meet/pile/float32/" + size.name + "/threads:" + std::to_string(threads),
        [=](benchmark::State& timing) { time_pile(timing, size.count, settled, threads); }, threads);
  }
  add(pace, "meet/lists/float32/" + size.name, [=](benchmark::State& timing) { time_lists(timing, size.count, settled); });
  add(pace, "meet/round/float32/lanes", [](benchmark::State& timing) { time_round(timing, By::lanes); });
  add(pace, "meet/round/float32/one", [](benchmark::State& timing) { time_round(timing, By::one); });
}

}  // namespace dvdx::bench
