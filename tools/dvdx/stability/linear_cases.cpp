// One particle under linear forces: its step is exact on paper, so that what is left is rounding.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "closed_form.hpp"
#include "stability/cases.hpp"
#include "stability/trial.hpp"

namespace dvdx::tool::stability {
namespace {

constexpr double hz60 = 1.0 / 60;

Scene spring_scene(double omega) {
  Scene scene;
  scene.add(Spring{.stiffness = omega * omega});
  return scene;
}

// One more particle than a register of 16 holds, each an amplitude of 1 m in another phase.
std::vector<Start> phases(double omega) {
  std::vector<Start> starts;
  for (int i = 0; i < 17; ++i)
    starts.push_back({{std::cos(i), std::sin(i), 0}, {-omega * std::sin(i), omega * std::cos(i), 0}});
  return starts;
}

// m^2/s^2, of one axis
template <class T>
double energy(const Trial<T>& trial, double omega, std::size_t axis, std::size_t i) {
  const double x = omega * trial.x(axis, i);
  const double v = trial.v(axis, i);
  return (x * x + v * v) / 2;
}

template <class T>
double worst_energy(const Trial<T>& trial, double omega, const std::vector<double>& start) {
  Worst worst;
  for (std::size_t i = 0; i < trial.count(); ++i) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double scale = omega * omega / 2;  // of the amplitude
      worst.see(std::abs(energy(trial, omega, axis, i) - start[2 * i + axis]) / scale);
    }
  }
  return worst.value;
}

template <class T>
std::vector<double> energies(const Trial<T>& trial, double omega) {
  std::vector<double> list;
  for (std::size_t i = 0; i < trial.count(); ++i) {
    for (std::size_t axis = 0; axis < 2; ++axis) list.push_back(energy(trial, omega, axis, i));
  }
  return list;
}

template <class T>
Worst quarter_turns(Way& way) {
  Worst worst;
  for (const double z : {std::numbers::pi / 2, std::numbers::pi, 2 * std::numbers::pi}) {
    const double omega = z / hz60;
    Trial<T> trial(way, spring_scene(omega), hz60, phases(omega));
    const auto start = energies(trial, omega);
    for (int n = 0; n < 100; ++n) {
      trial.step(1000);
      worst.see(worst_energy(trial, omega, start), fmt::format("omega h = {:.3g}", z));
    }
  }
  return worst;
}

}  // namespace

std::vector<Case> linear_cases() {
  return {
      {3, "quarter, half and full turns", "omega h = pi/2, pi, 2 pi: tan and sin at their poles and zeros, 1e5 steps",
       both<quarter_turns<double>, quarter_turns<float>>(1e-9, 1e-4, "E0", "energy constant")},
  };
}

}  // namespace dvdx::tool::stability
