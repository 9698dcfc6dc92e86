// Test setups of networks of springs, and the schemes that step them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dvdx/plan.hpp"
#include "kernel/passes/cloths.hpp"

namespace networks {

using namespace dvdx;
using test::Joined;

// Position and velocity of a particle.
inline double x(const std::vector<double>& values, std::size_t i, std::size_t axis) { return values[6 * i + axis]; }
inline double v(const std::vector<double>& values, std::size_t i, std::size_t axis) { return values[6 * i + 3 + axis]; }

inline std::vector<double> as_double(const std::vector<float>& values) { return {values.begin(), values.end()}; }

inline Joined with(Joined joined, const Coupling& coupling) {
  joined.scene.coupling = coupling;
  return joined;
}

inline constexpr std::array all_schemes = {
    Coupling{.scheme = Scheme::leapfrog},
    Coupling{.scheme = Scheme::fourth_order},
    Coupling{.scheme = Scheme::sequential, .substeps = 3},
    Coupling{.scheme = Scheme::sequential, .substeps = 3, .theta = 0.5},
    Coupling{.scheme = Scheme::sequential, .substeps = 3, .theta = 0.55},
    Coupling{.scheme = Scheme::sequential, .substeps = 3, .theta = 1, .sweeps = SweepOrder::forward},
    Coupling{.scheme = Scheme::accumulate, .method = Method::exact},
    Coupling{.scheme = Scheme::accumulate, .method = Method::pulse, .axis = PairAxis::start},
    Coupling{.scheme = Scheme::accumulate, .method = Method::combined},
};

// A damped sheet. The springs along its rows and columns have stiffness 0, which removes them, or one that is 0 in float32.
inline Joined damped_diagonals(double structural) {
  Joined sheet = test::sheet(9, 20, 50, 0.02);
  auto& grid = std::get<Grid>(sheet.scene.networks[0]);
  grid.structural = structural;
  grid.shear = 20;
  sheet.name += ", structural " + std::to_string(structural * 1e60) + "e-60";
  return sheet;
}

// Bodies on the x axis.
inline Joined on_a_line(const std::vector<double>& at, const std::vector<double>& speed, double acceleration) {
  Joined joined;
  for (std::size_t i = 0; i < at.size(); ++i) {
    joined.x.push_back({at[i], 0, 0});
    joined.v.push_back({speed[i], 0, 0});
  }
  joined.scene.add(Constant{.acceleration = {acceleration, 0, 0}});
  return joined;
}

}  // namespace networks
