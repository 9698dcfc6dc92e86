// A damped spring compared with Runge-Kutta: the work for a given precision.
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "bars/bars.hpp"
#include "dvdx/layouts/convert.hpp"
#include "dvdx/plan.hpp"
#include "support/held.hpp"
#include "support/plain.hpp"
#include "support/race.hpp"
#include "support/report.hpp"

namespace dvdx::bench {
namespace {

constexpr double spring_rate = 4 * 3.14159265358979323846 * 3.14159265358979323846 * 4;  // 2 Hz: W = (2 pi 2)^2, 1/s^2
constexpr double drag_rate = 0.3, horizon = 10;                                          // 1/s, s

// The relative error of the end state against the closed form: root mean square in the energy norm.
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

}  // namespace

void work_precision(Report& report, const Run& run) {
  work_precision<float>(report, run, "float32");
  work_precision<double>(report, run, "float64");
}

}  // namespace dvdx::bench
