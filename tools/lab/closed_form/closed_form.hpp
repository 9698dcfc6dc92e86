// The exact motion of scenes that have one, in long double. It shares no formula with the kernel's coefficients, because it
// judges them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// Position and velocity of one axis, m and m/s.
struct AxisState {
  long double x = 0;
  long double v = 0;
};

// x'' = -W x - g x' + sum_k polynomial[k] t^k + sum_j amplitude_j sin(angular_frequency_j t + phase_j)
struct AxisEquation {
  struct Sine {
    long double amplitude = 0;          // m/s^2
    long double angular_frequency = 0;  // rad/s
    long double phase = 0;              // rad
    bool operator==(const Sine&) const = default;
  };
  long double W = 0;                    // 1/s^2
  long double g = 0;                    // 1/s
  std::vector<long double> polynomial;  // m/s^2, m/s^3, ...
  std::vector<Sine> sines;
  bool operator==(const AxisEquation&) const = default;
};

// Returns the state of the axis at time t.
[[nodiscard]] AxisState solve(const AxisEquation& equation, AxisState start, long double t);

// A point above a wall under constant acceleration; s >= 0 is the distance. Each impact keeps `restitution` of the speed. Below
// 1, infinitely many impacts end at rest within a finite time.
struct BounceEquation {
  long double acceleration = 0;  // m/s^2, away from the wall
  long double restitution = 0;
};

[[nodiscard]] AxisState solve(const BounceEquation& equation, AxisState start, long double t);

enum class ClosedForm {
  none,
  affine,  // springs, drags, constants, polynomials and sinusoids
  bounce,  // constant acceleration above one plane without friction and viscosity
  balls,   // two balls that meet, or a row of them: closed_form/balls.hpp
  pair,    // two free bodies on one undamped spring that keeps its line, under constant accelerations
};

[[nodiscard]] ClosedForm closed_form_of(const SceneFile& file);

// States of all particles of a run at its sample times, the start first.
struct Path {
  std::size_t particles = 0;
  std::size_t times = 0;
  std::vector<long double> x;  // m, [time][particle][axis]
  std::vector<long double> v;  // m/s

  Path() = default;
  Path(std::size_t particles_, std::size_t times_)
      : particles(particles_), times(times_), x(particles_ * times_ * 3), v(particles_ * times_ * 3) {}
  [[nodiscard]] std::size_t index(std::size_t time, std::size_t particle, std::size_t axis) const noexcept {
    return (time * particles + particle) * 3 + axis;
  }
};

// The path at the times unit * counts[0], unit * counts[1], ... (rising, the first 0). The scene must have a closed form.
[[nodiscard]] Path exact_path(const SceneFile& file, double unit, std::span<const std::uint64_t> counts);

// One particle at one time, directly from the start. Rounds differently from exact_path, which goes from sample to sample.
[[nodiscard]] std::vector<AxisState> exact_state(const SceneFile& file, std::size_t particle, long double t);

}  // namespace dvdx::tool
