// One step of a linear system by each method and each scheme, as a matrix in float64, directly from the formulas. The library's
// coefficients and passes take no part.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dvdx/method.hpp"
#include "dvdx/network.hpp"

namespace dvdx::tool::stability {

// A particle on springs with their anchors at 0, along one axis.
struct Anchored {
  std::vector<double> W;                   // 1/s^2, for each spring
  double spring_damping = 0;               // 1/s, for the first spring
  double drag = 0;                         // 1/s
  Expansion expansion = Expansion::exact;  // for the drag
};

// Returns the matrix of (x, v) over a step h, s, by a method.
[[nodiscard]] Eigen::Matrix2d step_matrix(const Anchored& particle, Method method, double h);

// Particles along a line with all springs at rest. Displacements are smaller than the distances, so that springs stay linear.
struct Line {
  std::vector<double> mass;       // kg
  std::vector<Pair> pairs;        // ends and list ascending: the order in which sweeps run
  std::vector<double> stiffness;  // N/m, for each pair
  double damping = 0;             // kg/s, for every pair
};

// Returns the matrix over a sub-step h, s, of positions and velocities relative to particle 0: (x_1 - x_0, ..., v_1 - v_0,
// ...). The drift of the whole system is left out. No scheme changes it, it grows linearly in time, and it would hide the
// rounding of a radius of one. Sequential without theta adds the springs' accelerations, which are part of its state.
[[nodiscard]] Eigen::MatrixXd step_matrix(const Line& line, const Coupling& coupling, double h);

// rad/s
[[nodiscard]] double highest_frequency(const Line& line);

// The largest modulus of the eigenvalues.
[[nodiscard]] double spectral_radius(const Eigen::MatrixXd& matrix);

}  // namespace dvdx::tool::stability
