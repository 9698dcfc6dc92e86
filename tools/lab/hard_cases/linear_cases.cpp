// One particle under linear forces. Its step is exact in theory, so the error is rounding.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include "closed_form/closed_form.hpp"
#include "hard_cases/cases.hpp"
#include "hard_cases/linear_motion.hpp"
#include "hard_cases/trial.hpp"

namespace dvdx::tool::stability {
namespace {

// --- 1, 2: large angles -------------------------------------------------------------------------------------------------

template <class T>
double turning_error(CaseRun& way, double z, std::size_t n) {
  const double omega = z / hz60;
  return error_after<T>(way, {.W = omega * omega}, hz60, n, phases(omega), {.x = 1, .v = omega});
}

template <class T>
Worst one_large_step(CaseRun& way) {
  Worst worst;
  for (const double z : {3.0, 10.0, 1e2, 1e3, 1e5}) {
    const double unit = sizeof(T) == 8 ? epsilon<T> * z : 1;
    worst.see(turning_error<T>(way, z, 1) / unit, fmt::format("omega h = {:g}", z));
  }
  return worst;
}

template <class T>
Worst many_large_steps(CaseRun& way) {
  Worst worst;
  for (const double z : {3.0, 10.0, 1e2, 1e3}) worst.see(turning_error<T>(way, z, 1000), fmt::format("omega h = {:g}", z));
  return worst;
}

// --- 3, 11, 38: energy over long runs -----------------------------------------------------------------------------------

// |E/E0 - 1| of particles that oscillate about c with an amplitude of 1 m.
template <class T>
class EnergyDrift {
 public:
  EnergyDrift(const Trial<T>& trial, double omega, double c = 0) : trial_(trial), omega_(omega), c_(c), start_(energies()) {}

  [[nodiscard]] std::vector<double> now() const {
    auto drifts = energies();
    for (std::size_t i = 0; i < drifts.size(); ++i) drifts[i] = std::abs(drifts[i] / start_[i] - 1);
    return drifts;
  }

 private:
  [[nodiscard]] std::vector<double> energies() const {
    std::vector<double> list;
    for (const AxisState& axis : axes_of(trial_)) {
      const auto x = omega_ * (axis.x - c_);
      list.push_back(static_cast<double>((x * x + axis.v * axis.v) / 2));
    }
    return list;
  }

  const Trial<T>& trial_;
  long double omega_, c_;
  std::vector<double> start_;
};

template <class T>
std::vector<double> worst_drifts(Trial<T>& trial, double omega, double c, std::size_t steps, int looks = all_looks) {
  const EnergyDrift<T> drift(trial, omega, c);
  std::vector<double> worst(3 * trial.count());
  for (int look = 0; look < looks; ++look) {
    trial.step(steps / all_looks);
    const auto now = drift.now();
    for (std::size_t i = 0; i < now.size(); ++i) worst[i] = now[i] <= worst[i] ? worst[i] : now[i];
  }
  return worst;
}

template <class T>
Worst quarter_turns(CaseRun& way) {
  Worst worst;
  for (const double z : {std::numbers::pi / 2, std::numbers::pi, 2 * std::numbers::pi}) {
    const double omega = z / hz60;
    Trial<T> trial(way, Motion{.W = omega * omega}.scene(), hz60, phases(omega));
    for (const double drift : worst_drifts(trial, omega, 0, 100000)) worst.see(drift, fmt::format("omega h = {:.4g}", z));
  }
  return worst;
}

template <class T>
Worst several_springs(CaseRun& way) {
  Worst worst;
  for (const int springs : {2, 12}) {
    for (const double z : {0.1, 1.0, 2.5}) {
      const double square = z * z / (hz60 * hz60);
      Scene scene;
      double sum = 0;
      double moment = 0;
      for (int k = 0; k < springs; ++k) {
        const double stiffness = square * (k + 1) * 2 / (springs * (springs + 1));
        const double anchor = 0.25 * k - 1;
        sum += stiffness;
        moment += stiffness * anchor;
        scene.add(Spring{.stiffness = stiffness, .anchor = Vec3{anchor, anchor, anchor}});
      }
      Trial<T> trial(way, scene, hz60, phases(std::sqrt(sum), moment / sum));
      const auto where = fmt::format("{} springs, Omega h = {:g}", springs, z);
      for (const double drift : worst_drifts(trial, std::sqrt(sum), moment / sum, 10000000, way.looks)) worst.see(drift, where);
    }
  }
  return worst;
}

constexpr std::array long_run_angles = {1e-3, 1e-2, 0.1, 0.3, 0.7, 1.0, 1.7, 2.9};

std::vector<double> long_run_drifts(CaseRun& way, double z) {
  const double omega = z / hz60;
  Trial<float> trial(way, Motion{.W = omega * omega}.scene(), hz60, phases(omega));
  return worst_drifts(trial, omega, 0, 10000000, way.looks);
}

Worst long_run(CaseRun& way) {
  Worst worst;
  for (const double z : long_run_angles) {
    for (const double drift : long_run_drifts(way, z)) worst.see(drift, fmt::format("omega h = {:g}", z));
  }
  return worst;
}

Worst long_run_rms(CaseRun& way) {
  Worst worst;
  for (const double z : long_run_angles) {
    double squares = 0;
    const auto drifts = long_run_drifts(way, z);
    for (const double drift : drifts) squares += drift * drift;
    worst.see(std::sqrt(squares / static_cast<double>(drifts.size())), fmt::format("omega h = {:g}", z));
  }
  return worst;
}

// Damping so small that the energy falls by a tenth in 1e7 steps. These runs take the fused step, a matrix of rounded numbers.
Worst long_damped_run(CaseRun& way) {
  const std::size_t steps = 10000000 / all_looks * static_cast<std::size_t>(way.looks);
  Worst worst;
  for (const double z : {1e-3, 0.1, 1.0}) {
    const double omega = z / hz60;
    const Motion motion{.W = omega * omega, .g = 1e-8 / hz60};
    Trial<float> trial(way, motion.scene(), hz60, phases(omega));
    const auto start = axes_of(trial);
    trial.step(steps);
    const auto end = axes_of(trial);
    for (std::size_t i = 0; i < end.size(); ++i) {
      const AxisState exact = motion.after(start[i], static_cast<long double>(hz60) * steps);
      const auto energy = [&](const AxisState& at) { return omega * omega * at.x * at.x + at.v * at.v; };
      worst.see(static_cast<double>(std::abs(energy(end[i]) / energy(exact) - 1)), fmt::format("omega h = {:g}", z));
    }
  }
  return worst;
}

// --- 11: the separate methods lose or gain the energy that their determinants predict ---------------------------------------

// The determinant of a step of springs z_i = omega_i h, each integrated separately, in closed form.
long double determinant_of(Method method, const std::vector<double>& angles) {
  long double A = 0;  // coefficients of dv = -A x - B v, dx = -C x - D v, in units of h = 1
  long double B = 0;
  long double C = 0;
  long double D = 0;
  for (const long double z : angles) {
    const long double half = std::sin(z / 2);
    const long double a = z * std::sin(z);
    const long double b = 2 * half * half;
    A += a;
    B += b;
    C += method == Method::exact ? b : method == Method::average_acceleration ? a / 2 : a;
    D += method == Method::exact ? 1 - std::sin(z) / z : method == Method::average_acceleration ? b / 2 : b;
  }
  return (1 - C) * (1 - B) + (1 - D) * A;
}

double mean_energy(Trial<double>& trial, double omega) {
  constexpr int window = 314;  // steps of Omega h = 0.1: five periods, which average out the energy's own oscillation
  double sum = 0;
  for (int n = 0; n < window; ++n) {
    const double x = omega * trial.x(0);
    sum += (x * x + trial.v(0) * trial.v(0)) / 2;
    trial.step();
  }
  return sum / window;
}

Worst separate_methods(CaseRun& way) {
  Worst worst;
  const double omega = 0.1 / hz60;
  for (const std::size_t springs : {1U, 2U, 12U}) {
    for (const auto& [method, method_name, steps] : {std::tuple{Method::exact, "exact", 100000},
                                                     {Method::average_acceleration, "average_acceleration", 100000},
                                                     {Method::pulse, "pulse", 10000}}) {
      const std::vector<double> angles(springs, 0.1 / std::sqrt(static_cast<double>(springs)));
      Scene scene;
      scene.method = method;
      for (std::size_t k = 0; k < springs; ++k) scene.add(Spring{.stiffness = omega * omega / static_cast<double>(springs)});
      Trial<double> trial(way, scene, hz60, Start{{1, 0, 0}, {}});
      const double before = mean_energy(trial, omega);
      trial.step(static_cast<std::size_t>(steps - 314));
      const double got = mean_energy(trial, omega) / before;
      const auto formula = std::pow(determinant_of(method, angles), static_cast<long double>(steps));
      worst.see(static_cast<double>(std::abs(got / formula - 1)), fmt::format("{}, {} springs", method_name, springs));
    }
  }
  return worst;
}

// --- 5: tiny steps ------------------------------------------------------------------------------------------------------

constexpr double tiny = 1e-9;  // s

template <class T>
Worst tiny_steps(CaseRun& way) {
  constexpr double h = tiny;
  Trial<T> trial(way, Motion{.W = 100}.scene(), h, Start{{1, 1, 1}, {2, 2, 2}});
  trial.step(1000000);
  const auto exact = Motion{.W = 100}.after({1, 2}, 1000000.0L * h);
  Worst worst;
  worst.see(static_cast<double>(std::abs((trial.x(0) - exact.x) / (exact.x - 1))));
  return worst;
}

// A displacement of 2e-9 m is less than half an ulp of 1 m in float32, so the position must not change by a bit.
Worst tiny_steps_are_lost(CaseRun& way) {
  Trial<float> trial(way, Motion{.W = 100}.scene(), tiny, Start{{1, 1, 1}, {2, 2, 2}});
  trial.step(1000000);
  Worst worst;
  for (std::size_t axis = 0; axis < 3; ++axis) worst.see(std::abs(trial.x(axis) - 1));
  return worst;
}

// --- 14, 15: far away and very small ------------------------------------------------------------------------------------

enum class Home { world, local };  // the origin of the positions: the world's, or the anchor

template <class Kind>
double far_away_error(CaseRun& way, double far, double z, Home home) {
  const double omega = z / hz60;
  const Motion motion{.W = omega * omega, .c = far};
  Scene scene = motion.scene();
  if (home == Home::local) scene.origin = Vec3{far, far, far};
  Trial<Kind> trial(way, scene, hz60, phases(omega, home == Home::local ? 0 : far));
  const auto start = axes_of(trial);
  trial.step(10000);
  const auto end = axes_of(trial);
  const Motion seen{.W = motion.W, .c = home == Home::local ? 0 : far};
  Worst worst;
  for (std::size_t i = 0; i < end.size(); ++i) {
    worst.see(error_of(end[i], seen.after(start[i], 10000 * static_cast<long double>(hz60)), {.x = 1, .v = omega}));
  }
  return worst.value;
}

enum class Angle { small, one };  // omega h: up to 0.1, or 1

template <class Kind, Angle angle, Home home = Home::world>
Worst far_away(CaseRun& way) {
  Worst worst;
  for (const double far : {1e4, 1e6}) {
    for (const double z : angle == Angle::small ? std::vector{0.01, 0.1} : std::vector{1.0}) {
      worst.see(far_away_error<Kind>(way, far, z, home), fmt::format("at {:g} m, omega h = {:g}", far, z));
    }
  }
  return worst;
}

Worst far_away_plain(CaseRun& way) {
  Worst worst;
  for (const double z : {0.1, 1.0})
    worst.see(far_away_error<float>(way, 1e4, z, Home::world), fmt::format("omega h = {:g}", z));
  return worst;
}

template <class T>
constexpr double denormal = sizeof(T) == 4 ? 1e-40 : 1e-310;

template <class T>
Worst vanishing(CaseRun& way) {
  Worst worst;
  for (const double z : {0.01, 0.3, 2.0}) {
    const double omega = z / hz60;
    for (const double g : {0.0, 0.5}) {
      const double amplitude = denormal<T>;
      Trial<T> trial(way, Motion{.W = omega * omega, .g = g}.scene(), hz60,
                     Start{{amplitude, amplitude, 0}, {0, amplitude * omega, amplitude * omega}});
      trial.step(10000);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        worst.see(std::abs(trial.x(axis)), fmt::format("omega h = {:g}, g = {:g}", z, g));
        worst.see(std::abs(trial.v(axis)) / omega, fmt::format("omega h = {:g}, g = {:g}", z, g));
      }
    }
  }
  return worst;
}

// The time in seconds of 64 steps of 1024 particles with one amplitude.
template <class T>
double seconds_of(CaseRun& way, double amplitude) {
  Trial<T> trial(way, Motion{.W = 36}.scene(), hz60, std::vector<Start>(1024, {{amplitude, 0, amplitude}, {}}));
  const auto start = std::chrono::steady_clock::now();
  trial.step(64);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

template <class T>
Worst vanishing_time(CaseRun& way) {
  double small = std::numeric_limits<double>::infinity();
  double plain = std::numeric_limits<double>::infinity();
  for (int round = 0; round < 25; ++round) {
    small = std::min(small, seconds_of<T>(way, denormal<T>));
    plain = std::min(plain, seconds_of<T>(way, 1));
  }
  Worst worst;
  worst.see(small / plain);
  return worst;
}

}  // namespace

std::vector<Case> linear_cases() {
  return {
      {1,
       "many turns in one step",
       "omega h = 3 to 1e5: the argument of sin and cos has lost its digits",
       {{float64, one_large_step<double>, 4, "eps omega h A", "exact rotation"},
        {float32, one_large_step<float>, 3e-7, "A", "exact rotation"}}},
      {2, "many turns, 1000 steps", "omega h = 3 to 1e3: the error of every step's angle adds up",
       both<many_large_steps<double>, many_large_steps<float>>(1e-9, 1e-4, "A", "exact rotation")},
      {3, "quarter, half and full turns", "omega h = pi/2, pi, 2 pi: poles and zeros of tan and sin, 1e5 steps",
       both<quarter_turns<double>, quarter_turns<float>>(1e-9, 1e-4, "E0", "energy constant")},
      {5,
       "tiny steps",
       "omega = 10, h = 1e-9, 1e6 steps: each moves less than the position's rounding",
       {{float64, tiny_steps<double>, 1e-10, "of the way", "x - x0 = 1.949967e-3 m"},
        {float32_compensated, tiny_steps<Compensated>, 1e-7, "of the way", "x - x0 = 1.949967e-3 m"},
        {float32, tiny_steps_are_lost, 0, "m", "stands still, as is documented"}}},
      {11,
       "several springs on one particle",
       "2 to 12 anchored springs, Omega h = 0.1 to 2.5, 1e7 steps",
       {{float64, several_springs<double>, 1e-7, "E0", "energy constant", {}, RunsOn::only_best_whole},
        {float32, several_springs<float>, 1e-3, "E0", "energy constant", {}, RunsOn::only_best_whole},
        {float64, separate_methods, 0.01, "E", "separate methods: E/E0 = det^n"}}},
      {14,
       "far from the origin",
       "1 m of amplitude at 1e4 and 1e6 m, 1e4 steps: positions round to mm and to 0.06 m",
       {{float64, far_away<double, Angle::small>, 1e-5, "A", "exact rotation, omega h to 0.1"},
        {float64, far_away<double, Angle::one>, 3e-4, "A", "exact rotation, omega h = 1"},
        {float32_compensated, far_away<Compensated, Angle::small>, 1e-5, "A", "exact rotation, omega h to 0.1"},
        {float32_compensated, far_away<Compensated, Angle::one>, 3e-4, "A", "exact rotation, omega h = 1"},
        {float32, far_away<float, Angle::small, Home::local>, 1e-5, "A", "with an origin there: omega h to 0.1"},
        {float32, far_away<float, Angle::one, Home::local>, 3e-4, "A", "with an origin there: omega h = 1"},
        {float32, far_away_plain, 0.1, "A", "without, at 1e4 m: what is documented"}}},
      {15,
       "denormal amplitudes",
       "1e-40 m in float32, 1e-310 m in float64: each operation may take 30 times as long",
       {{float32, vanishing<float>, 1e-37, "m", "about 0"},
        {float64, vanishing<double>, 1e-307, "m", "about 0"},
        {float32, vanishing_time<float>, 1.5, "times 1 m's", "as fast"},
        {float64, vanishing_time<double>, 1.5, "times 1 m's", "as fast"}}},
      {38,
       "ten million steps",
       "omega h = 1e-3 to 2.9 in float32: rounded coefficients gain or lose energy at every step",
       {{float32, long_run, 1e-3, "E0", "energy constant, worst", {}, RunsOn::only_best_whole},
        {float32, long_run_rms, 3e-4, "E0", "energy constant, root mean square", {}, RunsOn::only_best_whole},
        {float32, long_damped_run, 0.4, "E", "damped by 1e-8 a step: what is documented", {}, RunsOn::only_best_whole}}},
  };
}

}  // namespace dvdx::tool::stability
