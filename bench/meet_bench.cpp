// Particles that meet: a settled pile of grains by sub-step, the rounds of pairs, and the building of the pair lists.
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "isa/passes.hpp"
#include "meet/lists.hpp"
#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"
#include "work/tasks.hpp"

namespace dvdx::bench {
namespace {

constexpr double d = 0.02;           // m
constexpr double room_beside = 0.5;  // grains: the offset of every second layer

Size heaped(Pace pace) { return pace == Pace::timed ? Size{"10000", 10000} : Size{"500", 500}; }

// Grains in layers. Every second layer is offset so that grains fall into hollows, and all are slightly out of line.
Held<float> heap(std::size_t count, std::size_t side) {
  Held<float> held = hold_padded<float>(count);
  scatter_about(held.state);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at[] = {i % side, i / (side * side), i / side % side};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double out_of_line = 0.02 * double{held.state.x[axis][i]};
      const double beside = axis != 1 && at[1] % 2 != 0 ? room_beside : 0;
      held.state.x[axis][i] = static_cast<float>((1.05 * static_cast<double>(at[axis]) + 0.55 + beside + out_of_line) * d);
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
  const double wide = (1.05 * static_cast<double>(side) + room_beside) * d;
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
  timing.counters["overlap"] = met.overlap_mean;
  Held<float> expected = heap(count, side);
  const auto alone = compile<float>(grains(side), {.step = frame}, expected.state);
  Held<float> same = heap(count, side);
  (void)alone->step(expected.state, 2);
  const auto together = compile<float>(grains(side), {.step = frame, .isa = Isa::reference}, same.state);
  (void)together->step(same.state, 2, parallel);
  if (!is_same_bits(same.state, expected.state, count)) timing.SkipWithError("differs from the reference");
}

// The grains' positions after `frames` frames, computed once.
const std::vector<MetListed<float>>& settled_heap(std::size_t count, std::size_t frames) {
  static std::map<std::size_t, std::vector<MetListed<float>>> heaps;
  std::vector<MetListed<float>>& x = heaps[count];
  if (!x.empty()) return x;
  const std::size_t side = side_of(count);
  Held<float> held = heap(count, side);
  const auto plan = compile<float>(grains(side), {.step = frame}, held.state);
  if (!plan || plan->step(held.state, frames) != StepResult::done) return x;
  for (std::size_t i = 0; i < count; ++i) x.push_back({{held.state.x[0][i], held.state.x[1][i], held.state.x[2][i]}, 0});
  return x;
}

// Builds lists with a reach of a fifth of a grain.
void time_lists(benchmark::State& timing, std::size_t count, std::size_t frames, Isa isa, int threads) {
  const std::vector<MetListed<float>>& x = settled_heap(count, frames);
  if (x.empty()) return timing.SkipWithError("no heap");
  const auto r = static_cast<float>(0.5 * d);
  const std::vector<float> a(count, r);
  PairLists<float> lists(count, 24 * count);
  const NearKernels<float>& near = find_passes(isa)->f32.meet.near;
  const ParallelFor parallel = on_threads(threads);
  const auto run = [&](std::size_t tasks, const auto& body) { for_each_task(parallel, tasks, body); };
  for (auto _ : timing) {
    if (lists.build(x.data(), a.data(), 1.15F * r, 0.4F * r, AllPairs(), near, run) != PairLists<float>::Found::all) {
      return timing.SkipWithError("too many");
    }
    benchmark::ClobberMemory();
  }
  const double grains = static_cast<double>(timing.iterations()) * static_cast<double>(count);
  using benchmark::Counter;
  timing.SetItemsProcessed(static_cast<std::int64_t>(grains));
  timing.counters["grain"] = Counter(grains, Counter::kIsRate | Counter::kInvert);
  timing.counters["listed"] = static_cast<double>(lists.first(count)) / static_cast<double>(count);
}

// Pairs that press on each other, in cache: a chain of particles.
struct Pressed {
  static constexpr std::size_t blocks = 64;
  std::vector<MetPairs> pairs{blocks};
  std::vector<Separations<float>> contacts{blocks};
  std::vector<Pulse<float>> pulses = std::vector<Pulse<float>>(blocks * meeting_lanes), against = pulses;
  std::vector<MeetPush<float>> pushed = std::vector<MeetPush<float>>(blocks * meeting_lanes + 1);

  Pressed() {
    for (MeetPush<float>& of : pushed) of.w = 3;
    for (std::size_t p = 0; p < pulses.size(); ++p) {
      const std::size_t k = p % meeting_lanes;
      Separation<float> contact;
      contact.n = {0, 1, 0};
      contact.gap = -1e-4F * static_cast<float>(1 + p % 13);
      contact.slip = {1e-4F * static_cast<float>(k), 0, 0};
      contacts[p / meeting_lanes].put(k, contact);
      pairs[p / meeting_lanes].i[k] = static_cast<std::uint32_t>(p);
      pairs[p / meeting_lanes].j[k] = static_cast<std::uint32_t>(p + 1);
      pulses[p].number = 1;
    }
  }
};

void time_round(benchmark::State& timing, Isa isa) {
  Pressed pressed;
  const Passes* const passes = find_passes(isa);
  const RoundTerms<float> terms{.pairs = pressed.pairs.data(),
                                .contacts = pressed.contacts.data(),
                                .pulses = pressed.pulses.data(),
                                .against = pressed.against.data(),
                                .pushed = pressed.pushed.data(),
                                .mu = 0.5F,
                                .beta = 0.5F};
  for (auto _ : timing) {
    passes->f32.meet.push(terms, 0, pressed.pulses.size());
    benchmark::ClobberMemory();
  }
  timing.SetItemsProcessed(static_cast<std::int64_t>(timing.iterations()) * static_cast<std::int64_t>(pressed.pulses.size()));
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
  for (const Isa isa : available_isas(Arithmetic::separate)) {
    add(pace, "meet/lists/float32/" + size.name + "/" + std::string(name(isa)),
        [=](benchmark::State& timing) { time_lists(timing, size.count, settled, isa, 1); });
    add(pace, "meet/round/float32/" + std::string(name(isa)), [=](benchmark::State& timing) { time_round(timing, isa); });
  }
  if (pace != Pace::timed) return;
  for (int threads = 1; threads <= most_threads(); ++threads) {
    const std::string name = "/threads:" + std::to_string(threads);
    const Isa isa = best_isa(Arithmetic::separate);
    add(
        pace, "meet/lists/float32/100000" + name,
        [=](benchmark::State& timing) { time_lists(timing, 100'000, 20, isa, threads); }, threads);
    add(
        pace, "meet/lists/float32/1000000" + name,
        [=](benchmark::State& timing) { time_lists(timing, 1'000'000, 1, isa, threads); }, threads);
  }
}

}  // namespace dvdx::bench
