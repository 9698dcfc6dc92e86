// Every bar that dvdx's speed is held to, in one run. A bar is a ratio of two pieces of work that are timed in turn; the table
// shows the median of the rounds and their span, so that what else the machine does can be seen.
//   dvdx_bars [--quick] [--only HEADING] [--json FILE]
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "dvdx/dvdx.h"
#include "dvdx/layouts/convert.hpp"
#include "dvdx/plan.hpp"
#include "free/free_motion.hpp"
#include "isa/passes.hpp"
#include "support/race.hpp"
#include "support/report.hpp"
#include "support/scenes.hpp"
#include "support/starts.hpp"
#include "support/structs.hpp"
#include "support/threads.hpp"
#include "support/turnover.hpp"

namespace dvdx::bench {
namespace {

constexpr std::size_t in_cache = 1024, in_second_cache = 16384, in_memory = 8'000'000;

struct Run {
  Effort effort;         // in cache
  Effort memory_effort;  // one call is a sample
  [[nodiscard]] Effort in_memory_on(int threads) const {
    Effort of_threads = memory_effort;
    of_threads.timer = threads > 1 ? Timer::wall : Timer::thread;
    return of_threads;
  }
};

template <class T>
Plan<T> make_plan(const Scene& scene, const Options& options = {}) {
  auto plan = compile<T>(scene, options);
  if (!plan) {
    std::fprintf(stderr, "%s\n", plan.error().message().c_str());
    std::exit(1);
  }
  return std::move(*plan);
}

// A plan, its particles, and how it is called.
template <class T>
struct Stepper {
  std::shared_ptr<Plan<T>> plan;
  Held<T> held;
  std::size_t steps = 1;
  ParallelFor parallel{};
  void operator()() { (void)plan->step(held.state, steps, parallel); }
};

template <class T>
Held<T> scattered(std::size_t count, Hold<T> hold = hold_padded<T>) {
  Held<T> held = hold(count);
  scatter_about(held.state);
  return held;
}

template <class T>
Stepper<T> stepper(const Scene& scene, const Held<T>& held, std::size_t steps, int threads = 1, const Options& options = {}) {
  return {std::make_shared<Plan<T>>(make_plan<T>(scene, options)), held, steps, on_threads(threads)};
}

// The six columns scaled, one slice of them a thread. The factor is 1: values stay what they are, and the compiler knows
// nothing.
struct Scaling {
  PlainArrays<float> arrays;
  int threads = 1;

  void operator()() {
    if (threads == 1) return scale_in_place(arrays, 1.0F, 0, arrays.count);
    const ParallelFor parallel = on_threads(threads);
    parallel.run(parallel.context, static_cast<std::size_t>(threads), slice, this);
  }
  static void slice(void* task, std::size_t index) {
    const auto& scaling = *static_cast<const Scaling*>(task);
    const std::size_t n = scaling.arrays.count, threads = static_cast<std::size_t>(scaling.threads);
    scale_in_place(scaling.arrays, 1.0F, n * index / threads, n * (index + 1) / threads);
  }
};

std::string per_step(double seconds, std::size_t particle_steps) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.3f ns", seconds * 1e9 / static_cast<double>(particle_steps));
  return text.data();
}

std::string against(const Race& race, std::size_t steps_a, std::size_t steps_b) {
  return per_step(race.a, steps_a) + " against " + per_step(race.b, steps_b) + " a particle and step";
}

// a/b of particle-steps per second or the like, where b did `more` times the work of a.
Race times(Race race, double more) {
  race.median *= more;
  race.lowest *= more;
  race.highest *= more;
  return race;
}

std::string threads_of(int threads) { return threads == 1 ? ", 1 thread" : ", 2 threads"; }

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
  // Many short samples: one of them finds both cores free, even where other programs run.
  bar("16384 particles, 64 steps a call", {.rounds = run.effort.rounds, .samples = 40, .seconds = 0, .timer = Timer::wall},
      small, 64);
  bar("8 million, 8 steps a call", run.in_memory_on(2), held, 8);
}

// The same particles before every call, so that a call always meets the same numbers.
struct FromStart {
  Stepper<float> step;
  State<float> start;
  void operator()() {
    copy(start, step.held.state);
    step();
  }
};

// The longest that any stretch of a decay takes, a step, by the kernel itself in the floating-point environment of the caller.
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

void decay(Report& report, const Run& run) {
  constexpr std::size_t steps = 16;
  const Held<float> start = scattered<float>(in_cache), resting = scattered<float>(in_cache),
                    scratch = scattered<float>(in_cache);
  stepper(overdamped(), resting, 400)();
  Held<float> fading = scattered<float>(in_cache);  // what a step's first products underflow from
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

constexpr double spring_rate = 4 * 3.14159265358979323846 * 3.14159265358979323846 * 4;  // 2 Hz: W = (2 pi 2)^2, 1/s^2
constexpr double drag_rate = 0.3, horizon = 10;                                          // 1/s, s

// Relative error of the end state against the closed form: the root mean square in the energy's norm.
template <class T>
double end_error(const State<T>& end, const State<T>& start) {
  const double wd = std::sqrt(spring_rate - drag_rate * drag_rate / 4), decay = std::exp(-drag_rate / 2 * horizon);
  const double cosine = decay * std::cos(wd * horizon), sine = decay * std::sin(wd * horizon) / wd;
  double error = 0, size = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < end.count; ++i) {
      const double x0 = static_cast<double>(start.x[axis][i]), v0 = static_cast<double>(start.v[axis][i]);
      const double x = x0 * cosine + (v0 + drag_rate / 2 * x0) * sine;
      const double v = v0 * cosine - (spring_rate * x0 + drag_rate / 2 * v0) * sine;
      const double dx = static_cast<double>(end.x[axis][i]) - x, dv = static_cast<double>(end.v[axis][i]) - v;
      error += spring_rate * dx * dx + dv * dv;
      size += spring_rate * x * x + v * v;
    }
  }
  return std::sqrt(error / size);
}

template <class T>
struct RungeKutta {
  State<T> state, start;
  std::size_t steps;
  void operator()() {
    copy(start, state);
    plain_runge_kutta(arrays_of(state), static_cast<T>(spring_rate), static_cast<T>(drag_rate),
                      static_cast<T>(horizon / static_cast<double>(steps)), steps);
  }
  double error() {
    (*this)();
    return end_error(state, start);
  }
};

struct Sprint {
  double seconds, error;
};

template <class T>
Sprint combined_run(const Run& run, const State<T>& start, const Held<T>& held) {
  Scene scene;
  scene.add(Spring{.stiffness = spring_rate}).add(Drag{.coefficient = drag_rate});
  Stepper<T> step = stepper(scene, held, 600);
  const double seconds = shortest(run.effort, [&] {
    copy(start, step.held.state);
    step();
  });
  return {seconds, end_error(held.state, start)};
}

template <class T>
void work_precision(Report& report, const Run& run, const std::string& type) {
  constexpr std::size_t count = 1000;
  const Held<T> start = scattered<T>(count), held = scattered<T>(count);
  const auto micro = [&](double seconds) { return seconds * 1e6 / count; };
  const Sprint ours = combined_run(run, start.state, held);
  std::array<char, 96> note{};
  std::snprintf(note.data(), note.size(), "600 steps, error %.1e", ours.error);
  report.figure("combined at 60 Hz, " + type, micro(ours.seconds), "us", note.data());

  RungeKutta<T> plain{held.state, start.state, 100};
  for (const double wanted : {1e-2, 1e-4, 1e-6, 1e-8}) {
    double error = plain.error();
    for (; error > wanted && plain.steps < 200'000; error = plain.error()) plain.steps += plain.steps / 8;
    const std::string name = "Runge-Kutta 4 to 1e" + std::to_string(std::lround(std::log10(wanted))) + ", " + type;
    if (error > wanted) {
      report.figure(name, 0, "us", "never reached");
      break;
    }
    const double seconds = shortest(run.effort, plain);
    std::snprintf(note.data(), note.size(), "%zu steps, error %.1e: %.1f times combined's", plain.steps, error,
                  seconds / ours.seconds);
    report.figure(name, micro(seconds), "us", note.data());
  }
}

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

void layouts(Report& report, const Run& run) {
  struct Kind {
    std::string name;
    Hold<float> hold;
  };
  for (const Kind& kind : {Kind{"padded", hold_padded<float>}, Kind{"full arrays", hold_full<float>},
                           Kind{"arrays pages apart", hold_pages<float>}, Kind{"structs", hold_aos<float>},
                           Kind{"tiles of 8", hold_tiles<float, 8>}, Kind{"tiles of 16", hold_tiles<float, 16>}}) {
    const auto figure = [&](const std::string& size, const Effort& effort, std::size_t count, std::size_t steps) {
      const double seconds = shortest(effort, stepper(meadow(), scattered<float>(count, kind.hold), steps));
      report.figure(kind.name + size, seconds * 1e9 / static_cast<double>(count * steps), "ns", "a particle and step");
    };
    figure(", L1, 1 step a call", run.effort, in_cache, 1);
    figure(", L1, 16 steps a call", run.effort, in_cache, 16);
    figure(", 8 million, 1 step a call", run.memory_effort, in_memory, 1);
  }
}

// A plain loop over the very same structs, and a scaling of all their bytes.
struct PlainStructs {
  PlainStructStep step;
  Held<float> held;
  PlainFlow flow;
  void operator()() { step(held.state.x[0].base, held.state.v[0].base, held.state.count, flow); }
};
struct ScaledStructs {
  Held<float> held;
  std::size_t numbers;
  void operator()() { scale_numbers(held.state.x[0].base, numbers, 1.0F); }
};

// One step a call.
void structs(Report& report, const Run& run) {
  struct Flown {
    std::string name;
    Scene scene;
    Flies flies;
    PlainFlow flow;
    double bound, bound_in_pieces, bound_in_memory;  // of a plain loop's time; the first two in cache
  };
  const PlainFlow falling{0, 3e-4F, 0, 0.0166F, {0, -0.16F, 0}, {0, -1.4e-3F, 0}, -1e9F};
  const std::array flown{
      Flown{"gravity and drag", fall(), Flies::free, falling, 0.9, 0.45, 1.0},
      Flown{"a floor to look for", with(fall(), far_floor({0, 1, 0})), Flies::above_a_floor, falling, 1.3, 1.3, 1.3},
      Flown{"a damped spring", meadow(), Flies::on_springs, {0.65F, 0.016F, 5.5e-3F, 0.0164F, {}, {}}, 0.9, 0.45, 1.0}};
  for (const Flown& flow : flown) {
    for (std::size_t k = 0; k < struct_shapes.size(); ++k) {
      const StructShape& shape = struct_shapes[k];
      const bool is_in_pieces = shape.size >= 8;
      const std::string name = shape.name + ", " + flow.name;
      const auto beside = [&](const Effort& effort, std::size_t count, const std::string& size, double bound) {
        const Held<float> held = hold_structs(shape, count);
        const auto ours = stepper(flow.scene, held, 1);
        Race race = bench::race(effort, ours, PlainStructs{plain_struct_step_native(k, flow.flies), held, flow.flow});
        report.bar(name + size + ": step's time / plain loop's", {false, bound}, race, against(race, count, count));
        race = bench::race(effort, ours, PlainStructs{plain_struct_step_any(k, flow.flies), held, flow.flow});
        report.figure(name + size + ", the loop without -march=native", race.median, "times", against(race, count, count));
        return held;
      };
      beside(run.effort, in_cache, ", L1", is_in_pieces ? flow.bound_in_pieces : flow.bound);
      const Held<float> held = beside(run.memory_effort, in_memory, ", 8 million", flow.bound_in_memory);
      if (flow.flies == Flies::above_a_floor) continue;
      const std::size_t numbers = in_memory * shape.size * (shape.are_apart() ? 2 : 1);
      const Race race = bench::race(run.memory_effort, stepper(flow.scene, held, 1), ScaledStructs{held, numbers});
      report.bar(name + ", 8 million: step's time / scaling's", {false, 1.15}, race, against(race, in_memory, in_memory));
    }
  }
}

// One step a call: more steps a call leave the particles in cache, and then the births are most of the work.
void turnover(Report& report, const Run& run) {
  constexpr std::size_t million = 1'000'000;
  for (const auto& [name, scene] :
       {std::pair{"falling", fall()}, std::pair{"with a floor to look for", with(fall(), far_floor({0, 1, 0}))}}) {
    for (int threads = 1; threads <= most_threads(); ++threads) {
      const Jet jet = make_jet(scene, million, 0.02, 1, threads, SurvivorOrder::kept);
      const Jet in_any_order = make_jet(scene, million, 0.02, 1, threads, SurvivorOrder::any);
      Held<float> same = hold_padded<float>(million);  // as the jet stands, so that as many touch the ground
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

// Gravity and drag by C's functions, over arrays of the caller's.
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

// Other layouts against columns.
void layouts_beside_columns(Report& report, const Run& run) {
  struct Tiled {
    std::string name;
    Hold<float> hold;
  };
  for (const auto& [name, scene] : {std::pair{"gravity and drag", fall()}, std::pair{"a damped spring", meadow()}}) {
    for (const Tiled& tiles : {Tiled{"tiles of 8", hold_tiles<float, 8>}, Tiled{"tiles of 16", hold_tiles<float, 16>}}) {
      for (const std::size_t steps : {std::size_t{1}, std::size_t{16}}) {
        const Race race = bench::race(run.effort, stepper(scene, scattered<float>(in_cache, tiles.hold), steps),
                                      stepper(scene, scattered<float>(in_cache), steps));
        report.bar(tiles.name + " / columns, L1, " + name + ", " + std::to_string(steps) + " a call", {false, 1.15}, race,
                   against(race, in_cache * steps, in_cache * steps));
      }
    }
  }
  const Held<float> sheet = hung();
  const Held<float> in_structs = hold_aos<float>(sheet.state.count);
  State<float> state = in_structs.state;
  copy(sheet.state, state);
  const Scene hung_by_corners = hung_sheet(Scheme::leapfrog);
  Race race = bench::race(run.effort, joined_stepper(hung_by_corners, in_structs), joined_stepper(hung_by_corners, sheet));
  report.bar("a sheet of 64 x 64, leapfrog, structs / columns", {false, 1.05}, race, "");
  const Scene floored = with(fall(), far_floor({0, 1, 0}));
  race = bench::race(run.effort, stepper(floored, scattered<float>(in_cache, hold_aos<float>), 1),
                     stepper(floored, scattered<float>(in_cache), 1));
  report.figure("a floor to look for, L1, structs / columns", race.median, "times", against(race, in_cache, in_cache));
}

// One plan's sheets, a copy of the same one each; or as many states of one plan.
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

// Clones of a plan, each with a state of its own, over threads.
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

// The cost of each feature to a sheet's step.
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

struct Section {
  std::string name;
  void (*run)(Report&, const Run&);
};

template <auto Time>
void in_memory_too(Report& report, const Run& run) {
  Time(report, run, scattered<float>(in_memory));
}

const std::vector<Section>& sections() {
  static const std::vector<Section> all{
      {"Affine pass",
       [](Report& report, const Run& run) {
         in_memory_too<affine_in_memory>(report, run);
         affine_in_cache(report, run);
       }},
      {"Steps a call", in_memory_too<steps_per_call>},
      {"Plain loops", in_memory_too<against_plain_loops>},
      {"Structs", structs},
      {"Threads", in_memory_too<two_threads>},
      {"Decay to rest", decay},
      {"Contact",
       [](Report& report, const Run& run) {
         in_memory_too<contact>(report, run);
         hits(report, run);
       }},
      {"Coefficients that differ", rates},
      {"A damped 2 Hz spring for 10 s, 1000 particles: microseconds a particle",
       [](Report& report, const Run& run) {
         work_precision<float>(report, run, "float32");
         work_precision<double>(report, run, "float64");
       }},
      {"Overheads and flows", in_memory_too<overheads>},
      {"Layouts",
       [](Report& report, const Run& run) {
         layouts(report, run);
         layouts_beside_columns(report, run);
       }},
      {"C API", c_api},
      {"A hundred sheets", hundred_sheets},
      {"A moving world", moving_world},
      {"Turnover", turnover},
  };
  return all;
}

// Those whose heading contains the text.
bool run_sections(Report& report, const Run& run, const std::string& text) {
  bool is_any = false;
  for (const Section& section : sections()) {
    if (section.name.find(text) == std::string::npos) continue;
    is_any = true;
    report.heading(section.name);
    section.run(report, run);
  }
  report.table();
  return is_any;
}

}  // namespace
}  // namespace dvdx::bench

int main(int argc, char** argv) {
  using namespace dvdx::bench;
  Run run{.effort = {}, .memory_effort = {.rounds = 9, .samples = 2, .seconds = 0}};
  std::string json, only;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--quick") {
      run = {.effort = {.rounds = 5, .samples = 3, .seconds = 5e-4},
             .memory_effort = {.rounds = 3, .samples = 1, .seconds = 0}};
    } else if (argument == "--json" && i + 1 < argc) {
      json = argv[++i];
    } else if (argument == "--only" && i + 1 < argc) {
      only = argv[++i];
    } else {
      std::fprintf(stderr, "usage: dvdx_bars [--quick] [--only HEADING] [--json FILE]\n");
      return 2;
    }
  }
  Report report;
  if (!run_sections(report, run, only)) {
    std::fprintf(stderr, "--only %s: no heading contains it\n", only.c_str());
    return 2;
  }
  if (!json.empty()) report.write_json(json);
  return 0;
}
