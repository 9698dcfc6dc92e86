// One step of a linear system by each method and each scheme, as a matrix in float64, straight from its formulas: nothing of
// the library's own coefficients or passes takes part.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dvdx/method.hpp"
#include "dvdx/network.hpp"

namespace dvdx::tool::stability {

// A particle on springs with their anchors at 0, along one axis.
struct Anchored {
  std::vector<double> W;                   // of each spring, 1/s^2
  double spring_damping = 0;               // of the first spring, 1/s
  double drag = 0;                         // 1/s
  Expansion expansion = Expansion::exact;  // of the drag
};

// (x, v) after a step h, s, of each method.
[[nodiscard]] Eigen::Matrix2d step_matrix(const Anchored& particle, Method method, double h);

// Particles along a line, all springs at rest; they move along it by less than they are apart, so that springs are linear.
struct Line {
  std::vector<double> mass;       // kg
  std::vector<Pair> pairs;        // ends and list ascending: the order in which sweeps are made
  std::vector<double> stiffness;  // N/m, a pair
  double damping = 0;             // kg/s, of every pair
};

// Positions and velocities relative to particle 0, after a sub-step h, s: (x_1 - x_0, ..., v_1 - v_0, ...). The drift of the
// whole, which no scheme touches, is left out: it grows in proportion to time and hides what rounding leaves of a radius of
// one. Sequential without theta: the springs' accelerations besides, of which it starts.
[[nodiscard]] Eigen::MatrixXd step_matrix(const Line& line, const Coupling& coupling, double h);

// rad/s
[[nodiscard]] double highest_frequency(const Line& line);

// The largest modulus of the eigenvalues.
[[nodiscard]] double spectral_radius(const Eigen::MatrixXd& matrix);

}  // namespace dvdx::tool::stability
