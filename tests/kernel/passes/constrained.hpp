// Test setups of particles joined by constraints, and their measurement.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"

namespace constrained {

using namespace dvdx;
using test::Joined;

inline double x(const std::vector<double>& values, std::size_t i, std::size_t axis) { return values[6 * i + axis]; }
inline double v(const std::vector<double>& values, std::size_t i, std::size_t axis) { return values[6 * i + 3 + axis]; }
inline double length(const std::vector<double>& values, std::size_t i, std::size_t j) {
  return std::hypot(x(values, j, 0) - x(values, i, 0), x(values, j, 1) - x(values, i, 1), x(values, j, 2) - x(values, i, 2));
}

inline Joined under_gravity(std::string name, double g) {
  Joined joined;
  joined.name = std::move(name);
  joined.scene.add(Constant{.acceleration = {0, -g, 0}});
  return joined;
}

// A bob on a rod of length l from a fixed point, at rest at an angle to the vertical.
inline Joined pendulum(double l, double angle, double g, double step) {
  Joined joined = under_gravity("pendulum", g);
  joined.x = {{0, 0, 0}, {l * std::sin(angle), -l * std::cos(angle), 0}};
  joined.v.resize(2);
  joined.scene.fixed = {0};
  joined.scene.add(Distance{.pairs = {{0, 1}}, .length = l});
  joined.step = step;
  return joined;
}

inline Joined rope(std::size_t links, double length, Bound bound = Bound::equal) {
  Joined joined = under_gravity("rope", 9.81);
  Distance distance{.pairs = {}, .length = length / static_cast<double>(links), .bound = bound};
  for (std::size_t i = 0; i <= links; ++i) {
    joined.x.push_back({length * static_cast<double>(i) / static_cast<double>(links), 0, 0});
    if (i != 0) distance.pairs.push_back({static_cast<std::uint32_t>(i - 1), static_cast<std::uint32_t>(i)});
  }
  joined.v.resize(links + 1);
  joined.scene.mass = 0.1 / static_cast<double>(links);
  joined.scene.add(distance);
  joined.scene.fixed = {0};
  return joined;
}

}  // namespace constrained
