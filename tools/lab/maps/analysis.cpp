#include "maps/analysis.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <numbers>
#include <set>
#include <unsupported/Eigen/MatrixFunctions>

namespace dvdx::tool::stability {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// ---- one particle ------------------------------------------------------------------------------------------------------

Matrix2d drift(double h) { return Matrix2d{{1, h}, {0, 1}}; }

// The exact motion of x'' = -W x - g x'.
Matrix2d motion(double W, double g, double h) { return (Matrix2d{{0, 1}, {-W, -g}} * h).exp(); }

// The contribution of a force to the free drift, (dx, dv) as rows over (x, v), derived from its dv.
Matrix2d with_dx(const Eigen::RowVector2d& dv, double share_of_h) {
  Matrix2d contribution;
  contribution << share_of_h * dv, dv;
  return contribution;
}

Matrix2d contribution(double W, double g, Method method, double h) {
  const Matrix2d exact = motion(W, g, h) - drift(h);
  switch (method) {
    case Method::symplectic_euler:
      return with_dx(Eigen::RowVector2d{-W * h, -g * h}, h);
    case Method::average_acceleration:
      return with_dx(exact.row(1), h / 2);
    case Method::pulse:
      return with_dx(exact.row(1), h);
    case Method::combined:
    case Method::exact:
      break;
  }
  return exact;
}

// The exponential exp(-q) is cut to 1 - q, with the matching displacement within the step.
Matrix2d first_order_drag(double g, Method method, double h) {
  const bool is_pulse = method == Method::pulse || method == Method::symplectic_euler;
  return with_dx(Eigen::RowVector2d{0, -g * h}, is_pulse ? h : h / 2);
}

// ---- particles on a line -----------------------------------------------------------------------------------------------

Index index(std::size_t i) { return static_cast<Index>(i); }

// The springs as matrices: stretch = J x; w holds the inverse masses.
struct Springs1d {
  explicit Springs1d(const Line& line)
      : n(index(line.mass.size())), J(MatrixXd::Zero(index(line.pairs.size()), n)), w(n), k(J.rows()) {
    for (std::size_t s = 0; s < line.pairs.size(); ++s) {
      // the force of a spring along the line is k (x_b - x_a - l), whichever end is ahead
      J(index(s), line.pairs[s][0]) = -1;
      J(index(s), line.pairs[s][1]) = 1;
      k[index(s)] = line.stiffness[s];
    }
    for (std::size_t i = 0; i < line.mass.size(); ++i) w[index(i)] = 1 / line.mass[i];
    c = VectorXd::Constant(J.rows(), line.damping);
  }
  [[nodiscard]] double both(Index s) const { return (J.row(s).array().square() * w.transpose().array()).sum(); }
  Index n;
  MatrixXd J;
  VectorXd w, k, c;
};

// The last factor acts first. Each product is evaluated at once: an expression type for each product takes long to compile.
MatrixXd product(std::initializer_list<MatrixXd> factors) {
  MatrixXd all = *factors.begin();
  for (const MatrixXd* factor = factors.begin() + 1; factor != factors.end(); ++factor) all = all * *factor;
  return all;
}

MatrixXd free_drift(Index n, double h) {
  MatrixXd step = MatrixXd::Identity(2 * n, 2 * n);
  step.topRightCorner(n, n) = MatrixXd::Identity(n, n) * h;
  return step;
}

// v -= h W (J^T k J x + J^T c J v)
MatrixXd pulse(const Springs1d& s, const VectorXd& k, const VectorXd& c, double h) {
  MatrixXd step = MatrixXd::Identity(2 * s.n, 2 * s.n);
  const MatrixXd WJt = h * s.w.asDiagonal() * s.J.transpose();
  const MatrixXd kJ = k.asDiagonal() * s.J;
  const MatrixXd cJ = c.asDiagonal() * s.J;
  step.bottomLeftCorner(s.n, s.n) -= WJt * kJ;
  step.bottomRightCorner(s.n, s.n) -= WJt * cJ;
  return step;
}

// v += h a0 + h^2/2 a1 + third a2: a0 by springs and damping; a1 = -C a0 and a2 = -C a1 by the damping.
MatrixXd damped_pulse(const Springs1d& s, double h, double third) {
  const MatrixXd rates = pulse(s, s.k, s.c, 1) - MatrixXd::Identity(2 * s.n, 2 * s.n);
  const MatrixXd a0 = rates.bottomRows(s.n);
  const MatrixXd C = -a0.rightCols(s.n);
  const MatrixXd a1 = -C * a0;
  MatrixXd step = MatrixXd::Identity(2 * s.n, 2 * s.n);
  step.bottomRows(s.n) += h * a0 + h * h / 2 * a1 - third * C * a1;
  return step;
}

MatrixXd leapfrog(const Springs1d& s, double h) {
  return product({free_drift(s.n, h / 2), damped_pulse(s, h, 0), free_drift(s.n, h / 2)});
}

// Blanes and Moan (2002), order 4 with six pulses. Each takes the share of the damping's third power that makes their product
// right.
MatrixXd fourth_order(const Springs1d& s, double h) {
  const std::vector<double> a{0.0792036964311957, 0.353172906049774, -0.0420650803577195};
  const std::vector<double> b{0.209515106613362, -0.143851773179818, 0.5 - (0.209515106613362 - 0.143851773179818)};
  const double a4 = 1 - 2 * (a[0] + a[1] + a[2]);
  const double mean = (b[0] + b[1] + b[2]) / 3;
  double spread = 0;
  double fourth = 0;
  for (const double each : b) {
    spread += (each - mean) * (each - mean);
    fourth += each * each * each * each / 24;
  }
  const auto drift_by = [&](double part) { return free_drift(s.n, part * h); };
  const auto pulse_by = [&](double part) {
    const double beta = part * part * part / 6 - fourth * (part - mean) / spread;
    return damped_pulse(s, part * h, beta * h * h * h);
  };
  return product({drift_by(a[0]), pulse_by(b[0]), drift_by(a[1]), pulse_by(b[1]), drift_by(a[2]), pulse_by(b[2]), drift_by(a4),
                  pulse_by(b[2]), drift_by(a[2]), pulse_by(b[1]), drift_by(a[1]), pulse_by(b[0]), drift_by(a[0])});
}

// Each pair acts as its own oscillator, with closing speed u and stretch e. Its ends take shares of the result by their w.
MatrixXd sum_of_pairs(const Springs1d& s, Method method, double h) {
  MatrixXd step = free_drift(s.n, h);
  for (Index pair = 0; pair < s.J.rows(); ++pair) {
    const double both = s.both(pair);
    const Matrix2d alone = contribution(s.k[pair] * both, s.c[pair] * both, method, h);
    const VectorXd share = s.w.cwiseProduct(s.J.row(pair).transpose()) / both;
    for (Index row = 0; row < 2; ++row) {
      for (Index column = 0; column < 2; ++column) {
        step.block(row * s.n, column * s.n, s.n, s.n) += alone(row, column) * share * s.J.row(pair);
      }
    }
  }
  return step;
}

// Leapfrog with a filtered pulse for each pair. An undamped pair alone then oscillates at its own frequency.
MatrixXd filtered(const Springs1d& s, double h) {
  VectorXd k = s.k;
  VectorXd c = s.c;
  for (Index pair = 0; pair < k.size(); ++pair) {
    const double z = std::sqrt(k[pair] * s.both(pair)) * h;
    const double sinc = z > 0 ? std::sin(z / 2) / (z / 2) : 1;
    k[pair] *= sinc * sinc;
    const double q = c[pair] * s.both(pair) * h;
    c[pair] *= q > 0 ? -std::expm1(-q) / q : 1;
  }
  return product({free_drift(s.n, h / 2), pulse(s, k, c, h), free_drift(s.n, h / 2)});
}

// The springs' order in a sweep: each takes the first colour that neither of its ends has. The sweep goes colour by colour.
std::vector<Index> sweep_order(const Line& line) {
  std::vector<std::set<std::size_t>> taken(line.mass.size());
  std::vector<std::size_t> colour;
  for (const auto& [a, b] : line.pairs) {
    std::size_t first = 0;
    while (taken[a].count(first) != 0 || taken[b].count(first) != 0) ++first;
    taken[a].insert(first);
    taken[b].insert(first);
    colour.push_back(first);
  }
  std::vector<Index> order(line.pairs.size());
  for (std::size_t s = 0; s < order.size(); ++s) order[s] = index(s);
  std::stable_sort(order.begin(), order.end(),
                   [&](Index p, Index q) { return colour[static_cast<std::size_t>(p)] < colour[static_cast<std::size_t>(q)]; });
  return order;
}

// The springs in the order of a sweep.
Springs1d swept(const Line& line, const Springs1d& in_list) {
  Springs1d s = in_list;
  const std::vector<Index> order = sweep_order(line);
  for (std::size_t row = 0; row < order.size(); ++row) {
    s.J.row(index(row)) = in_list.J.row(order[row]);
    s.k[index(row)] = in_list.k[order[row]];
  }
  return s;
}

// The springs' shift S = W J^T lambda solves (J W J^T + 1/stiff) lambda = by_state / stiff. Sweeps solve a triangular part of
// it: forwards D + L; forwards and backwards (D + L)^T D^-1 (D + L).
MatrixXd shift_of_sweeps(const Springs1d& s, const VectorXd& stiff, const MatrixXd& by_state, SweepOrder sweeps) {
  const MatrixXd WJt = s.w.asDiagonal() * s.J.transpose();
  MatrixXd A = s.J * WJt;
  A.diagonal() += stiff.cwiseInverse();
  MatrixXd lambda = A.triangularView<Eigen::Lower>().solve(stiff.cwiseInverse().asDiagonal() * by_state);
  if (sweeps == SweepOrder::symmetric) {
    const MatrixXd scaled = A.diagonal().asDiagonal() * lambda;
    lambda = A.transpose().triangularView<Eigen::Upper>().solve(scaled);
  }
  return WJt * lambda;
}

// With t = theta h, the springs demand -(k t^2 J x + c t^2 J v), with a stiffness of k t^2 + c t.
MatrixXd theta_scheme(const Line& line, const Springs1d& springs, const Coupling& coupling, double h) {
  const Springs1d s = swept(line, springs);
  const double theta = coupling.theta.value_or(1);
  const double t = theta * h;
  MatrixXd by_state(s.J.rows(), 2 * s.n);
  by_state << -(t * t) * s.k.asDiagonal() * s.J, -(t * t) * s.c.asDiagonal() * s.J;
  const MatrixXd shift = shift_of_sweeps(s, s.k * t * t + s.c * t, by_state, coupling.sweeps);
  MatrixXd kick = MatrixXd::Identity(2 * s.n, 2 * s.n);
  kick.topRows(s.n) += (2 * theta - 1) / (theta * theta) * shift;
  kick.bottomRows(s.n) += shift / (theta * theta * h);
  return product({free_drift(s.n, (1 - theta) * h), kick, free_drift(s.n, t)});
}

// The matrix of (x, v, a), between half drifts. The springs' acceleration f is taken at the fraction 1/(1 + rho) of the step:
//   v' = v + h ((1 - gamma) a + gamma b),  x' = x + h v + h^2 ((1/2 - beta) a + beta b),  f = alpha b + (1 - alpha) a.
MatrixXd generalized_alpha(const Line& line, const Springs1d& springs, double h) {
  const Springs1d s = swept(line, springs);
  const double z = highest_frequency(line) * h;
  const double rho = std::round(100 * (0.6 / (1 + std::pow(z / 6.5, 4)) + 0.35 / (1 + std::pow(z / 1.4, 4)))) / 100;
  const double part = 1 / (1 + rho);
  const double alpha = (2 - rho) * part;
  const double gamma = part * (3 - rho) / 2;
  const double beta = part * part;
  // x_f = x + part h v + x_a a + x_b f and v_f = v + v_a a + v_b f, by the values at the start, with b expressed by f and a
  const double a_in_b = -(1 - alpha) / alpha;
  const double x_a = part * h * h * (0.5 - beta + beta * a_in_b);
  const double x_b = part * h * h * beta / alpha;
  const double v_a = part * h * (1 - gamma + gamma * a_in_b);
  const double v_b = part * h * gamma / alpha;
  // f = -(k x_f + c v_f) along the springs; S = x_b f
  const VectorXd stiff = s.k * x_b + s.c * v_b;
  MatrixXd by_state(s.J.rows(), 3 * s.n);
  by_state << -x_b * s.k.asDiagonal() * s.J, -x_b * (s.k * (part * h) + s.c).asDiagonal() * s.J,
      -x_b * (s.k * x_a + s.c * v_a).asDiagonal() * s.J;
  const MatrixXd f = shift_of_sweeps(s, stiff, by_state, SweepOrder::symmetric) / x_b;
  const Index n = s.n;
  const MatrixXd one = MatrixXd::Identity(n, n);
  MatrixXd b = f / alpha;
  b.rightCols(n) += a_in_b * one;
  MatrixXd step = MatrixXd::Zero(3 * n, 3 * n);
  step.topRows(n) = h * h * beta * b;
  step.topLeftCorner(n, n) += one;
  step.block(0, n, n, n) += h * one;
  step.topRightCorner(n, n) += h * h * (0.5 - beta) * one;
  step.middleRows(n, n) = h * gamma * b;
  step.block(n, n, n, n) += one;
  step.block(n, 2 * n, n, n) += h * (1 - gamma) * one;
  step.bottomRows(n) = b;
  return step;
}

MatrixXd sequential(const Line& line, const Springs1d& springs, const Coupling& coupling, double h) {
  const bool is_default = !coupling.theta && coupling.sweeps == SweepOrder::symmetric;
  return is_default ? generalized_alpha(line, springs, h) : theta_scheme(line, springs, coupling, h);
}

MatrixXd whole_step(const Line& line, const Coupling& coupling, double h) {
  const Springs1d springs(line);
  switch (coupling.scheme) {
    case Scheme::leapfrog:
      return leapfrog(springs, h);
    case Scheme::fourth_order:
      return fourth_order(springs, h);
    case Scheme::sequential:
      return sequential(line, springs, coupling, h);
    case Scheme::accumulate:
    case Scheme::automatic:
      break;
  }
  return coupling.method == Method::combined ? filtered(springs, h) : sum_of_pairs(springs, coupling.method, h);
}

}  // namespace

Matrix2d step_matrix(const Anchored& particle, Method method, double h) {
  const bool has_exact_drag = particle.expansion == Expansion::exact;
  Matrix2d step = drift(h);
  if (method == Method::combined) {
    double W = 0;
    for (const double each : particle.W) W += each;
    step = motion(W, particle.spring_damping + (has_exact_drag ? particle.drag : 0), h);
  } else {
    for (std::size_t j = 0; j < particle.W.size(); ++j) {
      step += contribution(particle.W[j], j == 0 ? particle.spring_damping : 0, method, h);
    }
    if (has_exact_drag) step += contribution(0, particle.drag, method, h);
  }
  if (!has_exact_drag) step += first_order_drag(particle.drag, method, h);
  return step;
}

MatrixXd step_matrix(const Line& line, const Coupling& coupling, double h) {
  const Index n = index(line.mass.size());
  const MatrixXd step = whole_step(line, coupling, h);
  // input: particle 0 at 0; output: relative to particle 0
  const Index parts = step.rows() / n;
  MatrixXd relative(parts * (n - 1), parts * (n - 1));
  for (Index row = 0; row < parts; ++row) {
    for (Index column = 0; column < parts; ++column) {
      const auto block = step.block(row * n, column * n + 1, n, n - 1);
      relative.block(row * (n - 1), column * (n - 1), n - 1, n - 1) = block.bottomRows(n - 1).rowwise() - block.row(0);
    }
  }
  return relative;
}

double highest_frequency(const Line& line) {
  const Springs1d s(line);
  const MatrixXd root = s.k.cwiseSqrt().asDiagonal() * s.J * s.w.cwiseSqrt().asDiagonal();
  return std::sqrt(spectral_radius(root * root.transpose()));
}

double spectral_radius(const MatrixXd& matrix) { return matrix.eigenvalues().cwiseAbs().maxCoeff(); }

}  // namespace dvdx::tool::stability
