// One particle under linear forces: its coefficients, all dampings, and forces of time.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "closed_form/closed_form.hpp"
#include "hard_cases/cases.hpp"
#include "hard_cases/linear_motion.hpp"
#include "hard_cases/trial.hpp"

namespace dvdx::tool::stability {
namespace {

// --- 6, 7: coefficients -------------------------------------------------------------------------------------------------

// The change of x and v in one step by a unit displacement (-C and -A), a unit velocity (S) and a unit wind (both).
template <class T>
Worst spring_coefficients(CaseRun& way) {
  Worst worst;
  for (int decade = -8; decade < 4; ++decade) {
    for (const double digit : {1.0, 1.7, 3.1, 5.9, 8.3}) {
      const double omega = digit * std::pow(10.0, decade) / hz60;
      const double square = omega * omega;
      const long double exact_omega = std::sqrt(static_cast<long double>(square));
      const long double z = exact_omega * hz60;
      const auto where = fmt::format("omega h = {:.3g}", static_cast<double>(z));
      const auto see = [&](double got, long double exact) {
        worst.see(static_cast<double>(std::abs(got / exact - 1)) / epsilon<T>, where);
      };
      const long double half = std::sin(z / 2);
      Trial<T> pulled(way, Motion{.W = square, .c = -1}.scene(), hz60, Start{});
      Trial<T> kicked(way, Motion{.W = square}.scene(), hz60, Start{{}, {1, 1, 1}});
      pulled.step();
      kicked.step();
      if (std::abs(half) > 0.1L || z < 1) see(pulled.x(0), -2 * half * half);
      if (std::abs(std::sin(z)) > 0.1L || z < 1) {
        see(pulled.v(0), -exact_omega * std::sin(z));
        see(kicked.x(0), std::sin(z) / exact_omega);
      }
    }
  }
  return worst;
}

template <class T>
Worst drag_coefficients(CaseRun& way) {
  Worst worst;
  for (int decade = -8; decade < 4; ++decade) {
    for (const double digit : {1.0, 1.7, 3.1, 5.9, 8.3}) {
      const double g = digit * std::pow(10.0, decade) / hz60;
      Trial<T> blown(way, Motion{.g = g, .u = 1}.scene(), hz60, Start{});
      Trial<T> braked(way, Motion{.g = g}.scene(), hz60, Start{{}, {1, 1, 1}});
      blown.step();
      braked.step();
      const auto gains = Motion{.g = g, .u = 1}.after({}, hz60);
      const long double way_left = -std::expm1(-static_cast<long double>(g) * hz60) / g;
      for (const auto& [got, exact] : {std::pair{blown.v(0), gains.v}, {blown.x(0), gains.x}, {braked.x(0), way_left}}) {
        worst.see(static_cast<double>(std::abs(got / exact - 1)) / epsilon<T>, fmt::format("gamma h = {:.3g}", g * hz60));
      }
    }
  }
  return worst;
}

// --- 7: every damping and stiffness at once -----------------------------------------------------------------------------

// The state of x'' = -w x - q x' after 1 s:
struct Response {
  AxisState kicked;  // from x(0) = 0, v(0) = 1:          psi_1, psi_0
  AxisState pushed;  // by an acceleration of 1 from rest: psi_2, psi_1
  AxisState ramped;  // by an acceleration of t from rest: psi_3, psi_2
  AxisState curved;  // by an acceleration of t^2/2:       psi_4, psi_3
};

// The response where both modes have decayed. Their factors are exp(-l1) and exp(-l2) with rates l1 <= l2, or one shared decay
// of an oscillation. So small a remainder needs its own form.
Response died_away(long double w, long double b) {
  const long double square = b * b - w;
  const long double root = std::sqrt(std::abs(square));
  long double sine = std::exp(-b);  // exp(-b) sinh(root) / root, or sin in place of sinh
  long double cosine = std::exp(-b);
  if (square > 0) {
    const long double slow = std::exp(-w / (b + root));
    const long double fast = std::exp(-(b + root));
    sine = (slow - fast) / (2 * root);
    cosine = (slow + fast) / 2;
  } else if (square < 0) {
    sine *= std::sin(root) / root;
    cosine *= std::cos(root);
  }
  const long double psi2 = (1 - cosine - b * sine) / w;
  const long double psi3 = (1 - sine - 2 * b * psi2) / w;
  const long double psi4 = (0.5L - psi2 - 2 * b * psi3) / w;
  return {{sine, cosine - b * sine}, {psi2, sine}, {psi3, psi2}, {psi4, psi3}};
}

Response response(double w, double q) {
  const double b = q / 2;
  const double slower = b * b > w ? w / (b + std::sqrt(b * b - w)) : b;
  if (slower > 20) return died_away(w, b);
  return {solve({.W = w, .g = q, .polynomial = {}, .sines = {}}, {0, 1}, 1),
          solve({.W = w, .g = q, .polynomial = {1}, .sines = {}}, {0, 0}, 1),
          solve({.W = w, .g = q, .polynomial = {0, 1}, .sines = {}}, {0, 0}, 1),
          solve({.W = w, .g = q, .polynomial = {0, 0, 0.5L}, .sines = {}}, {0, 0}, 1)};
}

// The scale of psi_k's error: its own value or, if it oscillates through zero, the amplitude exp(-q/2)/z^k. A response that has
// decayed to nothing is measured relative to a tiny part of its largest value, which is below 1/q.
double envelope(int k, long double exact, double w, double q) {
  if (k == 0) return 1;
  const double swing = 4 * w > q * q ? std::exp(-q / 2) * std::pow(w, -0.5 * k) : 0.0;
  return std::max({std::abs(static_cast<double>(exact)), swing, 1e-20 / std::max(1.0, q)});
}

struct Grid2 {
  std::vector<double> w, q;
};

Grid2 damping_grid() {
  Grid2 grid;
  const auto add = [&](double w, double q) {
    grid.w.push_back(w);
    grid.q.push_back(q);
  };
  for (const double w : {0.0, 1e-16, 1e-12, 1e-8, 1e-6, 1e-4, 0.01, 1.0, 2.1, 44.9, 100.0, 504.0, 4727.0, 1e4, 1e6}) {
    for (const double q : {0.0, 1e-12, 1e-8, 1e-4, 0.01, 1.0, 1.97, 2.03, 14.1, 100.0, 1e4, 1e6, 1e8}) add(w, q);
  }
  for (const double q : {0.02, 1.3, 2.0, 20.0, 140.0}) {  // around critical damping
    for (const double off : {-1e-3, -1e-7, -1e-13, 0.0, 1e-13, 1e-7, 1e-3}) add(q * q / 4 * (1 + off), q);
  }
  return grid;
}

// Each pair (w, q) is a particle with its own stiffness and drag, pushed by a polynomial of time.
Scene grid_scene(const Grid2& grid, const std::vector<double>& push) {
  Scene scene;
  scene.add(Spring{.stiffness = grid.w});
  scene.add(Drag{.coefficient = grid.q});
  Polynomial polynomial;
  for (const double term : push) polynomial.acceleration.push_back({term, term, term});
  if (!push.empty()) scene.add(polynomial);
  return scene;
}

// The error in units of max(16, z) eps of the envelope.
Worst all_dampings(CaseRun& way) {
  const Grid2 grid = damping_grid();
  const std::vector<Start> at_rest(grid.w.size());
  Trial<double> kicked(way, grid_scene(grid, {}), 1, std::vector<Start>(grid.w.size(), {{}, {1, 1, 1}}));
  Trial<double> pushed(way, grid_scene(grid, {1}), 1, at_rest);
  Trial<double> ramped(way, grid_scene(grid, {0, 1}), 1, at_rest);
  Trial<double> curved(way, grid_scene(grid, {0, 0, 0.5}), 1, at_rest);
  for (auto* trial : {&kicked, &pushed, &ramped, &curved}) trial->step();
  Worst worst;
  for (std::size_t i = 0; i < grid.w.size(); ++i) {
    const double w = grid.w[i];
    const double q = grid.q[i];
    const Response exact = response(w, q);
    const double unit = epsilon<double> * std::max(16.0, std::sqrt(w));
    const auto see = [&](int k, double got, long double value) {
      worst.see(static_cast<double>(std::abs(got - value)) / (unit * envelope(k, value, w, q)),
                fmt::format("psi_{} at w = {:g}, q = {:g}", k, w, q));
    };
    see(0, kicked.v(0, i), exact.kicked.v);
    see(1, kicked.x(0, i), exact.kicked.x);
    see(1, pushed.v(0, i), exact.pushed.v);
    see(2, pushed.x(0, i), exact.pushed.x);
    see(2, ramped.v(0, i), exact.ramped.v);
    see(3, ramped.x(0, i), exact.ramped.x);
    see(3, curved.v(0, i), exact.curved.v);
    see(4, curved.x(0, i), exact.curved.x);
  }
  return worst;
}

// Values far beyond any scene. The error is relative to the response of a free particle to the same push, which bounds every
// response.
Worst extreme_dampings(CaseRun& way) {
  Grid2 grid;
  for (const double w : {0.0, 1e-300, 1e-20, 1.0, 1e20, 1e100, 1e200, 1e260}) {
    for (const double q : {0.0, 1e-300, 1e-20, 1.0, 1e20, 1e100, 1e200, 1e260}) {
      grid.w.push_back(w);
      grid.q.push_back(q);
    }
  }
  Trial<double> kicked(way, grid_scene(grid, {}), 1, std::vector<Start>(grid.w.size(), {{}, {1, 1, 1}}));
  Trial<double> pushed(way, grid_scene(grid, {1}), 1, std::vector<Start>(grid.w.size()));
  kicked.step();
  pushed.step();
  Worst worst;
  for (std::size_t i = 0; i < grid.w.size(); ++i) {
    const auto where = fmt::format("w = {:g}, q = {:g}", grid.w[i], grid.q[i]);
    for (const double value : {kicked.v(0, i), kicked.x(0, i), pushed.v(0, i), 2 * pushed.x(0, i)}) {
      worst.see(std::abs(value), where);
    }
  }
  return worst;
}

// --- 8, 9, 10: damping --------------------------------------------------------------------------------------------------

template <class T>
Worst nearly_critical(CaseRun& way) {
  Worst worst;
  for (const double g : {1.0, 8.0, 40.0, 256.0}) {
    for (const double off : {0.0, 1e-13, -1e-13, 1e-10, 1e-7, -1e-7, 1e-5, 1e-3, -1e-3}) {
      const Motion motion{.W = g * g / 4 * (1 + off), .g = g};
      for (const double h : {hz60, 0.1, 1.0}) {
        for (const std::size_t n : {1U, 60U}) {
          worst.see(error_after<T>(way, motion, h, n, phases(g / 2), {.x = 1, .v = g / 2}),
                    fmt::format("g = {:g}, W/(g/2)^2 - 1 = {:g}, {} steps of {:.3g} s", g, off, n, h));
        }
      }
    }
  }
  return worst;
}

// A slow creep returns by more than half an ulp of a float32 in each step (held), or by less (lost).
enum class Creep { held, lost };

template <class T, Creep creep>
Worst overdamped(CaseRun& way) {
  Worst worst;
  for (const auto& [q, w] :
       {std::pair{20.0, 1.0}, {1e3, 10.0}, {1e3, 2e5}, {2e5, 1e-3}, {1e5, 3e8}, {1.6e7, 3e8}, {1.6e7, 1e-3}}) {
    if ((w / q < 6e-8) != (creep == Creep::lost)) continue;
    const Motion motion{.W = w / (hz60 * hz60), .g = q / hz60};
    const double omega = std::sqrt(motion.W);
    for (const std::size_t n : {1U, 1000U}) {
      worst.see(error_after<T>(way, motion, hz60, n, phases(omega), {.x = 1, .v = omega}),
                fmt::format("g h = {:g}, W h^2 = {:g}, {} steps", q, w, n));
    }
  }
  return worst;
}

// A fall from rest. The errors are relative to the distance and the speed.
template <class T>
Worst falling_in_drag(CaseRun& way) {
  Worst worst;
  for (int decade = -12; decade <= 6; ++decade) {
    const double q = std::pow(10.0, decade);
    const Motion motion{.g = q / hz60, .a = -9.81};
    for (const std::size_t n : {1U, 1000U}) {
      const auto exact = motion.after({}, static_cast<long double>(hz60) * static_cast<long double>(n));
      const Scale scale{std::abs(static_cast<double>(exact.x)), std::abs(static_cast<double>(exact.v))};
      worst.see(error_after<T>(way, motion, hz60, n, {Start{}}, scale), fmt::format("gamma h = {:g}, {} steps", q, n));
    }
  }
  return worst;
}

Worst terminal_velocity_apart(CaseRun& way) {
  Worst worst;
  for (const double q : {1e-3, 0.1, 1.0, 10.0}) {
    Scene scene = Motion{.g = q / hz60, .a = -9.81}.scene();
    scene.method = Method::exact;
    Trial<double> trial(way, scene, hz60, Start{});
    trial.step(static_cast<std::size_t>(50 / std::min(q, 1.0)));
    const double terminal = -9.81 * hz60 / q;
    worst.see(std::abs(trial.v(0) / terminal / (q / -std::expm1(-q)) - 1), fmt::format("gamma h = {:g}", q));
  }
  return worst;
}

// --- 12, 13: forcing ----------------------------------------------------------------------------------------------------

struct Forced {
  double W, g, frequency, h;

  // The magnitude of the denominator of the steady response: 0 at resonance.
  [[nodiscard]] double nearness() const {
    const double theta = frequency * h;
    return std::hypot(W * h * h - theta * theta, g * h * theta);
  }
};

// The error relative to the largest amplitude so far.
double forced_error(CaseRun& way, const Forced& at) {
  constexpr std::size_t steps = 64;
  Scene scene;
  if (at.W != 0) scene.add(Spring{.stiffness = at.W});
  if (at.g != 0) scene.add(Drag{.coefficient = at.g});
  scene.add(Sinusoid{.acceleration = {1, 1, 1}, .angular_frequency = at.frequency, .phase = 0.3});
  const AxisEquation equation{
      .W = at.W, .g = at.g, .polynomial = {}, .sines = {{1, at.frequency, static_cast<long double>(0.3)}}};
  Trial<double> trial(way, scene, at.h, Start{});
  Scale scale{0, 0};
  std::vector<double> errors_x;
  std::vector<double> errors_v;
  for (std::size_t n = 1; n <= steps; ++n) {
    trial.step();
    const auto exact = solve(equation, {}, static_cast<long double>(at.h) * static_cast<long double>(n));
    errors_x.push_back(static_cast<double>(std::abs(trial.x(0) - exact.x)));
    errors_v.push_back(static_cast<double>(std::abs(trial.v(0) - exact.v)));
    scale.x = std::max(scale.x, std::abs(static_cast<double>(exact.x)));
    scale.v = std::max(scale.v, std::abs(static_cast<double>(exact.v)));
  }
  return std::max(*std::max_element(errors_x.begin(), errors_x.end()) / scale.x,
                  *std::max_element(errors_v.begin(), errors_v.end()) / scale.v);
}

enum class Resonance { near, far };

template <Resonance which>
Worst forced(CaseRun& way) {
  Worst worst;
  for (const double h : {hz60, 1.0}) {
    for (const double W : {4.0, 100.0, 1e4}) {
      for (const double off : {0.0, 1e-13, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 0.5}) {
        for (const double g : {0.0, 1e-9, 1e-5, 0.1, 3.0}) {
          const Forced at{W, g, std::sqrt(W) * (1 + off), h};
          if ((at.nearness() < 1e-6) != (which == Resonance::near)) continue;
          worst.see(forced_error(way, at),
                    fmt::format("W = {:g}, g = {:g}, Omega/omega - 1 = {:g}, h = {:.3g} s", W, g, off, h));
        }
      }
    }
  }
  return worst;
}

// The velocity that one step at 1e6 s gains from a forcing, relative to the largest gain.
template <class T>
Worst late_phase(CaseRun& way) {
  constexpr double h = 0.9;
  constexpr std::size_t steps = 1111111;
  constexpr double frequency = 7;
  Scene scene;
  scene.add(Sinusoid{.acceleration = {1, 1, 1}, .angular_frequency = frequency});
  Trial<T> trial(way, scene, h, Start{});
  trial.step(steps);
  trial.state().v[0][0] = 0;
  trial.step();
  const long double theta = static_cast<long double>(frequency) * h;
  const long double most = 2 * std::sin(theta / 2) / frequency;
  Worst worst;
  worst.see(static_cast<double>(std::abs(trial.v(0) / most - std::sin((steps + 0.5L) * theta))));
  return worst;
}

}  // namespace

std::vector<Case> drag_cases() {
  return {
      {6,
       "coefficients",
       "omega h and gamma h from 1e-8 to 1e4: 1 - cos z and 1 - exp(-q) lose their digits",
       {{float64, spring_coefficients<double>, 4, "eps", "1 - cos z, omega sin z, sin z/omega"},
        {float32, spring_coefficients<float>, 2, "eps", "1 - cos z, omega sin z, sin z/omega"},
        {float64, drag_coefficients<double>, 4, "eps", "1 - exp(-q), (1 - exp(-q))/q and what is left of 1"},
        {float32, drag_coefficients<float>, 2, "eps", "1 - exp(-q), (1 - exp(-q))/q and what is left of 1"}}},
      {7,
       "every damping at once",
       "w = W h^2 from 0 to 1e6 and q = g h from 0 to 1e8, a pair each particle, critical and undamped among them",
       {{float64, all_dampings, 1, "max(16, z) eps", "the oscillator functions psi_0 to psi_4"},
        {float64, extreme_dampings, 1 + 1e-15, "of the free motion", "w and q to 1e260: finite, no more than free"}}},
      {8, "nearly critical damping", "|W/(g/2)^2 - 1| = 0 and 1e-13 to 1e-3: sin and sinh of next to nothing over itself",
       both<nearly_critical<double>, nearly_critical<float>>(1e-13, 2e-6, "A", "closed form")},
      {9,
       "overdamped",
       "g h to 1.6e7, W h^2 to 3e8: cosh overflows, the slow root cancels",
       {{float64, overdamped<double, Creep::held>, 1e-13, "A", "closed form"},
        {float32, overdamped<float, Creep::held>, 5e-7, "A", "closed form"},
        {float64, overdamped<double, Creep::lost>, 1e-13, "A", "closed form, creeping by less than 6e-8 a step"},
        {float32_compensated, overdamped<Compensated, Creep::lost>, 5e-7, "A",
         "closed form, creeping by less than 6e-8 a step"},
        {.precision = float32,
         .check = overdamped<float, Creep::lost>,
         .limit = 5e-7,
         .unit = "A",
         .expected = "closed form, creeping by less than 6e-8 a step",
         .known_miss = KnownMiss{5.1e-6, "a step of less than half an ulp is lost; a compensated state keeps it"}}}},
      {10,
       "falling in drag",
       "gamma h = 1e-12 to 1e6, 1 and 1000 steps: gravity and drag integrated apart miss the terminal velocity",
       {{float64, falling_in_drag<double>, 1e-13, "of the way", "closed form"},
        {float32, falling_in_drag<float>, 5e-5, "of the way", "closed form"},
        {float64, terminal_velocity_apart, 1e-12, "", "integrated apart: too fast by q/(1 - exp(-q))"}}},
      {12,
       "forced at resonance",
       "Omega = omega and 1e-13 to 0.5 beside it, damped and not: the closed form is 0/0",
       {{float64, forced<Resonance::near>, 1e-7, "of the amplitude", "closed form, |p| < 1e-6"},
        {float64, forced<Resonance::far>, 1e-11, "of the amplitude", "closed form, elsewhere"}}},
      {13,
       "phase after 1e6 s",
       "1.1e6 steps of 0.9 s: sin(7 t) of a rounded time",
       {{float64, late_phase<double>, 1e-9, "", "sin(Omega t)"},
        {float32, late_phase<float>, 1.2e-7, "", "sin(Omega t), to float32's rounding"}}},
  };
}

}  // namespace dvdx::tool::stability
