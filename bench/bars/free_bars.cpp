// Free particles compared with plain loops, over threads, and at surfaces.
#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "bars/bars.hpp"
#include "dvdx/layouts/convert.hpp"
#include "dvdx/plan.hpp"
#include "free/free_motion.hpp"
#include "isa/passes.hpp"
#include "support/held.hpp"
#include "support/plain.hpp"
#include "support/race.hpp"
#include "support/report.hpp"
#include "support/scenes.hpp"
#include "support/starts.hpp"
#include "support/threads.hpp"

namespace dvdx::bench {
namespace {

struct PlainAos {
  std::vector<PlainParticle<float>> particles;
  PlainForces<float> forces = plain_meadow<float>();
  void operator()() { plain_aos_step(particles, forces, static_cast<float>(frame)); }
};

struct PlainSoa {
  PlainArrays<float> arrays;
  PlainForces<float> forces = plain_meadow<float>();
  void operator()() { plain_soa_step(arrays, 1.0F, forces, static_cast<float>(frame)); }
};

PlainAos plain_aos(const State<float>& state) {
  PlainAos plain;
  plain.particles.resize(state.count);
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      plain.particles[i].x[axis] = state.x[axis][i];
      plain.particles[i].v[axis] = state.v[axis][i];
    }
    plain.particles[i].mass = 1;
  }
  return plain;
}

// Restores the same particles before every call, so that each call processes the same numbers.
struct FromStart {
  Stepper<float> step;
  State<float> start;
  void operator()() {
    copy(start, step.held.state);
    step();
  }
};

// Returns the largest time per step of any stretch of a decay, by the kernel itself in the caller's floating-point environment.
double longest_unflushed_step(Isa isa) {
  constexpr std::size_t stretch = 25, until = 1000, tries = 5;
  const Scene scene = overdamped();
  const ShapeMemories<float> shapes(scene.contacts.size());
  const FreeMotion<float> motion(scene, Options{}, find_passes(isa)->f32.free, std::nullopt, {}, shapes);
  const Offsets<float> offsets{};
  std::array<double, until / stretch> shortest{};
  for (std::size_t attempt = 0; attempt < tries; ++attempt) {
    const Held<float> held = scattered<float>(in_cache);
    Block<float> block;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block.x[axis] = held.state.x[axis].base;
      block.v[axis] = held.state.v[axis].base;
    }
    block.count = in_cache;
    auto work = [&] { motion.kernels->at(motion.flow, motion.features)(block, motion.terms, {&offsets, 0, stretch}); };
    for (double& seconds : shortest) {
      const double taken = time_of(work, 1, Timer::thread);
      seconds = attempt == 0 ? taken : std::min(seconds, taken);
    }
  }
  return *std::max_element(shortest.begin(), shortest.end()) / stretch;
}

}  // namespace

void affine_in_memory(Report& report, const Run& run, const Held<float>& held) {
  for (int threads = 1; threads <= most_threads(); ++threads) {
    const Race race =
        bench::race(run.in_memory_on(threads), Scaling{arrays_of(held.state), threads}, stepper(meadow(), held, 1, threads));
    report.bar("affine, 8 million: scaling's time / step's" + threads_of(threads), {true, 0.90}, race,
               per_step(race.a, in_memory) + " against " + per_step(race.b, in_memory) + " a particle");
  }
}

void affine_in_cache(Report& report, const Run& run) {
  const Held<float> held = scattered<float>(in_cache);
  struct Form {
    Arithmetic arithmetic;
    double bound;
  };
  for (const Form form : {Form{Arithmetic::separate, 2.2}, Form{Arithmetic::contracted, 1.5}}) {
    const Options options{.arithmetic = form.arithmetic};
    for (const std::size_t steps : {std::size_t{16}, std::size_t{1}}) {
      Race race = bench::race(run.effort, stepper(meadow(), held, steps, 1, options), Scaling{arrays_of(held.state)});
      race = times(race, 1 / static_cast<double>(steps));
      const std::string name = "affine, L1, " + std::string(dvdx::name(form.arithmetic)) + ": step's time / scaling's, " +
                               std::to_string(steps) + " a call";
      const std::string note = against(race, in_cache * steps, in_cache);
      if (steps == 1) {
        report.figure(name, race.median, "times", note);
      } else {
        report.bar(name, {false, form.bound}, race, note);
      }
    }
  }
}

void steps_per_call(Report& report, const Run& run, const Held<float>& held) {
  for (int threads = 1; threads <= most_threads(); ++threads) {
    const Race race =
        bench::race(run.in_memory_on(threads), stepper(meadow(), held, 1, threads), stepper(meadow(), held, 8, threads));
    report.bar("8 million: particle-steps/s, 8 steps a call / 1" + threads_of(threads), {true, 3.5}, times(race, 8),
               against(race, in_memory, 8 * in_memory));
  }
}

void against_plain_loops(Report& report, const Run& run, const Held<float>& held) {
  const Held<float> small = scattered<float>(in_cache);
  Race race = bench::race(run.effort, plain_aos(small.state), stepper(meadow(), small, 16));
  report.bar("plain array of structs / step, L1, 16 steps a call", {true, 10}, times(race, 16),
             against(race, in_cache, 16 * in_cache));
  race = bench::race(run.effort, plain_aos(small.state), stepper(meadow(), small, 1));
  report.figure("the same, 1 step a call", race.median, "times", against(race, in_cache, in_cache));
  const Options contracted{.arithmetic = Arithmetic::contracted};
  race = bench::race(run.effort, plain_aos(small.state), stepper(meadow(), small, 16, 1, contracted));
  report.figure("the same, contracted", race.median * 16, "times", against(race, in_cache, 16 * in_cache));
  race = bench::race(run.effort, PlainSoa{arrays_of(small.state)}, stepper(meadow(), small, 16));
  report.figure("plain six arrays, autovectorised / step, L1, 16 steps a call", race.median * 16, "times",
                against(race, in_cache, 16 * in_cache));

  race = bench::race(run.memory_effort, plain_aos(held.state), stepper(meadow(), held, 1));
  report.bar("plain array of structs / step, 8 million, 1 step a call", {true, 4}, race, against(race, in_memory, in_memory));
  race = bench::race(run.memory_effort, PlainSoa{arrays_of(held.state)}, stepper(meadow(), held, 1));
  report.figure("plain six arrays, autovectorised / step, 8 million, 1 step a call", race.median, "times",
                against(race, in_memory, in_memory));
}

void two_threads(Report& report, const Run& run, const Held<float>& held) {
  if (most_threads() < 2) return;
  const Held<float> small = scattered<float>(in_second_cache);
  const auto bar = [&](const std::string& name, const Effort& effort, const Held<float>& particles, std::size_t steps) {
    const Race race = bench::race(effort, stepper(meadow(), particles, steps, 1), stepper(meadow(), particles, steps, 2));
    const std::size_t work = particles.state.count * steps;
    report.bar("two threads / one, " + name, {true, 1.85}, race, against(race, work, work));
  };
  // Many short samples: one of them finds both cores free even while other programs run.
  bar("16384 particles, 64 steps a call", {.rounds = run.effort.rounds, .samples = 40, .seconds = 0, .timer = Timer::wall},
      small, 64);
  bar("8 million, 8 steps a call", run.in_memory_on(2), held, 8);
}

void decay(Report& report, const Run& run) {
  constexpr std::size_t steps = 16;
  const Held<float> start = scattered<float>(in_cache), resting = scattered<float>(in_cache),
                    scratch = scattered<float>(in_cache);
  stepper(overdamped(), resting, 400)();
  Held<float> fading = scattered<float>(in_cache);  // the first products of a step underflow
  for (auto* columns : {&fading.state.x, &fading.state.v}) {
    for (auto& column : *columns) {
      for (std::size_t i = 0; i < in_cache; ++i) column[i] *= 1e-38F;
    }
  }
  const FromStart in_motion{stepper(overdamped(), scratch, steps), start.state};
  const std::size_t work = in_cache * steps;
  const auto bar = [&](const std::string& name, const State<float>& from) {
    const Race race = bench::race(run.effort, FromStart{stepper(overdamped(), scratch, steps), from}, in_motion);
    report.bar(name + " / in motion, L1", {false, 1.1}, race, against(race, work, work));
  };
  bar("decayed to rest", resting.state);
  bar("in the range of denormal numbers", fading.state);
  for (const Isa isa : available_isas()) {
    const double moving = shortest(run.effort, stepper(overdamped(), scratch, steps, 1, {.isa = isa})) / steps;
    report.figure("what denormals would cost unflushed, " + std::string(name(isa)), longest_unflushed_step(isa) / moving,
                  "times", "the slowest 25 steps of the decay");
  }
}

void contact(Report& report, const Run& run, const Held<float>& held) {
  const Held<float> small = scattered<float>(in_cache);
  struct Kind {
    std::string name;
    Scene scene;
  };
  const Plane level = far_floor({0, 1, 0}), oblique = far_floor({1, 2, 0.5});
  for (const Kind& kind : {Kind{"drift", fall()}, Kind{"fused", meadow()}}) {
    for (const auto& [shape, plane] : {std::pair{"level", level}, std::pair{"oblique", oblique}}) {
      const Race race = bench::race(run.effort, stepper(with(kind.scene, plane), small, 16), stepper(kind.scene, small, 16));
      report.bar(std::string("one ") + shape + " plane, no hits / no contact, L1, " + kind.name, {false, 1.6}, race,
                 against(race, 16 * in_cache, 16 * in_cache));
    }
    const Race race = bench::race(run.memory_effort, stepper(with(kind.scene, level), held, 1), stepper(kind.scene, held, 1));
    report.bar("one level plane, no hits / no contact, 8 million, " + kind.name, {false, 1.1}, race,
               against(race, in_memory, in_memory));
  }
}

void hits(Report& report, const Run& run) {
  Scene thrown;
  thrown.add(Constant{.acceleration = {0, -9.81, 0}});
  const auto figure = [&](const std::string& name, const Plane& plane, void (*start)(State<float>&), const std::string& note) {
    Held<float> held = hold_padded<float>(in_cache);
    start(held.state);
    const double seconds = shortest(run.effort, stepper(with(thrown, plane), held, 16));
    report.figure(name, seconds * 1e9 / (16 * in_cache), "ns", note);
  };
  figure("every particle hits in every step", floor(), start_hopping<float>,
         "a path of its own for each: an impact's root, its pulse, and the search on the rest of the step");
  figure("every particle at rest on the ground", ground(), start_resting<float>,
         "no impact to resolve: the clamp and friction");
}

void rates(Report& report, const Run& run) {
  std::array<std::vector<double>, 7> columns;
  for (auto& column : columns) column.resize(in_cache);
  auto& [W, g, A, B, C, S, X] = columns;
  for (std::size_t i = 0; i < in_cache; ++i) {
    W[i] = 40 / (1 + static_cast<double>(i) / in_cache);
    g[i] = 0.32 / (1 + static_cast<double>(i) / in_cache);
  }
  const RateRun work{in_cache, frame, W.data(), g.data(), A.data(), B.data(), C.data(), S.data(), X.data()};
  for (const Isa isa : available_isas()) {
    const double seconds = shortest(run.effort, [&] { find_passes(isa)->f64.free.rate(work); });
    report.figure("coefficients each, " + std::string(name(isa)), seconds * 1e9 / in_cache, "ns", "a particle, five each");
  }
  const double seconds =
      shortest(run.effort, [&] { plain_coefficients(work.W, work.g, work.h, work.count, work.A, work.B, work.C); });
  report.figure("coefficients each, plain loop with the standard library", seconds * 1e9 / in_cache, "ns",
                "a particle, three each, text book's formulas");
}

}  // namespace dvdx::bench
