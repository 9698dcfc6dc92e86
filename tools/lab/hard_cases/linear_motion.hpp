// One particle under linear forces: its exact motion, and the error of a trial.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "closed_form/closed_form.hpp"
#include "hard_cases/trial.hpp"

namespace dvdx::tool::stability {

// x'' = a - W (x - c) - g (v - u) along each axis: 1/s^2, 1/s, m/s^2, m, m/s
struct Motion {
  double W = 0, g = 0, a = 0, c = 0, u = 0;

  [[nodiscard]] Scene scene() const {
    Scene scene;
    if (W != 0) scene.add(Spring{.stiffness = W, .anchor = Vec3{c, c, c}});
    if (g != 0) scene.add(Drag{.coefficient = g, .wind = {u, u, u}});
    if (a != 0) scene.add(Constant{.acceleration = {a, a, a}});
    return scene;
  }
  [[nodiscard]] AxisState after(AxisState start, long double t) const {
    const long double force = static_cast<long double>(a) + static_cast<long double>(g) * static_cast<long double>(u);
    AxisState end = solve({.W = W, .g = g, .polynomial = {force}, .sines = {}}, {start.x - c, start.v}, t);
    end.x += c;
    return end;
  }
};

// 16 particles with an amplitude of 1 m about c, each in another phase.
inline std::vector<Start> phases(double omega, double c = 0) {
  std::vector<Start> starts;
  for (int i = 0; i < 16; ++i) {
    const double turn = 0.37 * i;
    starts.push_back({{c + std::cos(turn), c + std::sin(turn), c}, {-omega * std::sin(turn), omega * std::cos(turn), omega}});
  }
  return starts;
}

template <class T>
std::vector<AxisState> axes_of(const Trial<T>& trial) {
  std::vector<AxisState> axes;
  for (std::size_t i = 0; i < trial.count(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) axes.push_back({trial.x(axis, i), trial.v(axis, i)});
  }
  return axes;
}

// The scales of the errors of position and velocity. The larger scaled error counts.
struct Scale {
  double x = 1;  // m
  double v = 1;  // m/s
};

inline double error_of(const AxisState& got, const AxisState& exact, const Scale& scale) {
  const auto x = static_cast<double>(std::abs(got.x - exact.x)) / scale.x;
  const auto v = static_cast<double>(std::abs(got.v - exact.v)) / scale.v;
  return std::isnan(x) || x > v ? x : v;
}

// Returns the worst error of all particles after n steps of h.
template <class T>
double error_after(CaseRun& way, const Motion& motion, double h, std::size_t n, const std::vector<Start>& starts,
                   const Scale& scale) {
  Trial<T> trial(way, motion.scene(), h, starts);
  const auto start = axes_of(trial);
  trial.step(n);
  const auto end = axes_of(trial);
  const long double t = static_cast<long double>(h) * static_cast<long double>(n);
  Worst worst;
  for (std::size_t i = 0; i < end.size(); ++i) worst.see(error_of(end[i], motion.after(start[i], t), scale));
  return worst.value;
}

}  // namespace dvdx::tool::stability
