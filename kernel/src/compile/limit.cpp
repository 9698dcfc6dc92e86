#include "compile/limit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "compile/sweep_scheme.hpp"
#include "math/elementary.hpp"

namespace dvdx {
namespace {

// What one iteration may cost in all, so that making a plan of a million particles stays a matter of seconds.
constexpr double spring_visits = 4e7;
constexpr int most_iterations = 100;

enum class Direction { any, start };  // stiff in every direction, or along each spring as it stands at the start

// y = M^-1/2 K M^-1/2 x, three numbers a particle.
class Stiffness {
 public:
  Stiffness(std::span<const JoinedPair> springs, std::span<const double> w, std::span<const Vec3> start, Direction direction)
      : springs_(springs), direction_(direction) {
    for (const double inverse_mass : w) root_.push_back(std::sqrt(inverse_mass));
    if (direction == Direction::any) return;
    for (const JoinedPair& s : springs) {
      Eigen::Vector3d d;
      for (std::size_t axis = 0; axis < 3; ++axis) d[static_cast<Eigen::Index>(axis)] = start[s.b][axis] - start[s.a][axis];
      const double r = d.norm();
      n_.push_back(r > 0 ? Eigen::Vector3d(d / r) : Eigen::Vector3d::Zero());
      across_.push_back(r > 0 ? std::max(0.0, 1 - s.l / r) : 1.0);
    }
  }

  [[nodiscard]] Eigen::Matrix3Xd times(const Eigen::Matrix3Xd& x) const {
    Eigen::Matrix3Xd y = Eigen::Matrix3Xd::Zero(3, x.cols());
    for (std::size_t s = 0; s < springs_.size(); ++s) {
      const auto [a, b, k, l, c] = springs_[s];
      const Eigen::Vector3d stretch = root_[b] * x.col(b) - root_[a] * x.col(a);
      Eigen::Vector3d pull = k * stretch;
      if (direction_ == Direction::start) {
        const double along = n_[s].dot(stretch);
        pull = k * (along * n_[s] + across_[s] * (stretch - along * n_[s]));
      }
      y.col(b) += root_[b] * pull;
      y.col(a) -= root_[a] * pull;
    }
    return y;
  }

 private:
  std::span<const JoinedPair> springs_;
  Direction direction_;
  std::vector<double> root_;
  std::vector<Eigen::Vector3d> n_;
  std::vector<double> across_;
};

// A start that no symmetry of a mesh is orthogonal to.
Eigen::Matrix3Xd scattered(std::size_t count) {
  Eigen::Matrix3Xd x(3, static_cast<Eigen::Index>(count));
  std::uint64_t state = 1;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    x.data()[i] = static_cast<double>(state >> 11) * 0x1p-52 - 1;
  }
  return x.normalized();
}

// The largest eigenvalue by Lanczos' iteration, from below: to 1e-3 in some tens of steps where power iteration takes
// thousands. Infinite where it cannot be found.
double largest_eigenvalue(const Stiffness& K, std::size_t count, int iterations) {
  std::vector<double> diagonal;
  std::vector<double> beside;
  Eigen::Matrix3Xd before = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(count));
  Eigen::Matrix3Xd now = scattered(count);
  for (int step = 0; step < iterations; ++step) {
    Eigen::Matrix3Xd next = K.times(now);
    diagonal.push_back(next.cwiseProduct(now).sum());
    next -= diagonal.back() * now;
    if (!beside.empty()) next -= beside.back() * before;
    const double norm = next.norm();
    // What follows the last direction that the start has a part in is rounding.
    if (!(norm > 1e-8 * *std::max_element(diagonal.begin(), diagonal.end())) || step + 1 == iterations) break;
    beside.push_back(norm);
    before = std::move(now);
    now = next / norm;
  }
  // Moved away from 0, where the solver finds no end among the motions that stretch no spring. It scales a whole matrix to its
  // own tolerance, and three diagonals it does not.
  const double shift = *std::max_element(diagonal.begin(), diagonal.end());
  const auto size = static_cast<Eigen::Index>(diagonal.size());
  Eigen::MatrixXd T = shift * Eigen::MatrixXd::Identity(size, size);
  T.diagonal() += Eigen::Map<const Eigen::VectorXd>(diagonal.data(), size);
  T.diagonal(-1) = Eigen::Map<const Eigen::VectorXd>(beside.data(), size - 1);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(T, Eigen::EigenvaluesOnly);
  if (solver.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return std::max(0.0, solver.eigenvalues()[size - 1] - shift);
}

int affordable_iterations(std::size_t springs) {
  return static_cast<int>(
      std::clamp(spring_visits / static_cast<double>(std::max<std::size_t>(springs, 1)), 8.0, double{most_iterations}));
}

struct SumBound {
  double value = 0;
  std::uint32_t particle = 0;
};

template <class Weight>
SumBound sum_bound(std::span<const JoinedPair> springs, std::span<const double> w, const Weight& weight) {
  std::vector<double> sum(w.size(), 0);
  for (const JoinedPair& s : springs) {
    sum[s.a] += weight(s);
    sum[s.b] += weight(s);
  }
  SumBound bound;
  for (const JoinedPair& s : springs) {
    const double of_a = w[s.a] * sum[s.a];
    const double of_b = w[s.b] * sum[s.b];
    if (of_a + of_b > bound.value) bound = {of_a + of_b, of_a >= of_b ? s.a : s.b};
  }
  return bound;
}

bool are_isolated(std::span<const JoinedPair> springs, std::span<const double> w) {
  std::vector<bool> has_spring(w.size(), false);
  for (const JoinedPair& s : springs) {
    for (const std::uint32_t i : {s.a, s.b}) {
      if (w[i] != 0 && has_spring[i]) return false;
      has_spring[i] = true;
    }
  }
  return true;
}

double symbol_bound(const Grid& grid, std::span<const double> w) {
  constexpr int samples = 128;
  constexpr int farthest = 3 * samples;  // two rows down and one column across, or two columns
  std::array<double, 2 * farthest + 1> rise{};
  for (int n = -farthest; n <= farthest; ++n) {
    rise[static_cast<std::size_t>(n + farthest)] = 1 - sincos(std::numbers::pi * n / samples).cos;
  }
  const std::vector<GridDirection> directions = directions_of(grid);
  double largest = 0;
  for (int p = 0; p <= samples; ++p) {
    for (int q = -samples; q <= samples; ++q) {
      double sum = 0;
      for (const GridDirection& d : directions) {
        const int n = p * static_cast<int>(d.down) + q * static_cast<int>(d.right);
        sum += 2 * d.k * rise[static_cast<std::size_t>(n + farthest)];
      }
      largest = std::max(largest, sum);
    }
  }
  return largest * *std::max_element(w.begin(), w.end());
}

// The matrix of a splitting's step of one oscillator x'' = -x, row by row.
struct Oscillation {
  std::array<double, 2> x{1, 0};
  std::array<double, 2> v{0, 1};
};

Oscillation oscillation(const Splitting& s, double z) {
  Oscillation step;
  for (std::size_t k = 0; k < s.a.size(); ++k) {
    for (std::size_t i = 0; i < 2; ++i) step.x[i] += s.a[k] * z * step.v[i];
    for (std::size_t i = 0; i < 2 && k < s.b.size(); ++i) step.v[i] -= s.b[k] * z * step.x[i];
  }
  return step;
}

// The largest frequency * h up to which it is so.
template <class IsSo>
double oscillator_limit(const Splitting& s, const IsSo& is_so) {
  constexpr double resolution = 1e-3;
  for (double z = resolution; z < 10; z += resolution) {
    if (!is_so(oscillation(s, z))) return z - resolution;
  }
  return 10;
}

bool is_stable(const Oscillation& step) { return std::abs(step.x[0] + step.v[1]) <= 2 * (1 + 1e-12); }

// A step that is its own inverse has x[0] = v[1] and keeps  x[1] v^2 - v[0] x^2:  x^2 + v^2 swings between that over x[1] and
// that over -v[0].
bool is_calm(const Oscillation& step) {
  const double ratio = -step.v[0] / step.x[1];
  return is_stable(step) && ratio > 0.5 && ratio < 2;
}

// The highest frequency times sub-step at which Brown's sum does not grow yet, the least over chains, rings and cloth (`dvdx
// stability`). The more springs a particle has, the lower its own springs' frequencies stand below the highest one, and the
// nearer all sums come to leapfrog: with 7 springs on each of 8 particles the average one and the filtered pulse take 2.09. The
// exact one grows at every step, by 1e-3 of the amplitude at 0.5.
double accumulate_limit(Method method) {
  switch (method) {
    case Method::pulse:
      return 1.4;
    case Method::exact:
      return 0.5;
    case Method::average_acceleration:
    case Method::combined:
    case Method::symplectic_euler:
      break;
  }
  return 2.0;
}

}  // namespace

Frequencies frequencies(std::span<const JoinedPair> springs, const Grid* grid, std::span<const double> w,
                        std::span<const Vec3> start) {
  Frequencies found;
  if (springs.empty()) return found;
  const int iterations = affordable_iterations(springs.size());
  const SumBound sums = sum_bound(springs, w, [](const JoinedPair& s) { return s.k; });
  double bound = sums.value;
  if (grid != nullptr) {
    bound = std::min(bound, symbol_bound(*grid, w));
  } else if (iterations == most_iterations) {
    // Lanczos' value comes from below; two hundredths more than what it misses after this many steps.
    bound = std::min(bound, 1.02 * largest_eigenvalue(Stiffness(springs, w, start, Direction::any), w.size(), iterations));
  }
  found.particle = sums.particle;
  found.is_isolated = are_isolated(springs, w);
  found.bound = std::sqrt(bound);
  found.start =
      std::sqrt(std::min(bound, largest_eigenvalue(Stiffness(springs, w, start, Direction::start), w.size(), iterations)));
  found.damping = sum_bound(springs, w, [](const JoinedPair& s) { return s.c; }).value;
  return found;
}

// Blanes and Moan, J. Comput. Appl. Math. 142 (2002) 313, table 2, S6 of order 4.
Splitting splitting(const Coupling& coupling) {
  if (coupling.scheme == Scheme::sequential) {
    if (is_generalized_alpha(coupling)) return {{0.5, 0.5}, {1.0}};
    const double theta = theta_of(coupling);
    if (theta == 1) return {{1.0}, {1.0}};
    return {{theta, 1 - theta}, {1.0}};
  }
  if (coupling.scheme == Scheme::fourth_order) {
    constexpr double a1 = 0.0792036964311957;
    constexpr double a2 = 0.353172906049774;
    constexpr double a3 = -0.0420650803577195;
    constexpr double a4 = 1 - 2 * (a1 + a2 + a3);
    constexpr double b1 = 0.209515106613362;
    constexpr double b2 = -0.143851773179818;
    constexpr double b3 = 0.5 - (b1 + b2);
    return {{a1, a2, a3, a4, a3, a2, a1}, {b1, b2, b3, b3, b2, b1}};
  }
  return {{0.5, 0.5}, {1.0}};
}

double scheme_limit(const Coupling& coupling) {
  if (coupling.scheme == Scheme::sequential) return std::numeric_limits<double>::infinity();
  if (coupling.scheme == Scheme::accumulate) return accumulate_limit(coupling.method);
  return oscillator_limit(splitting(coupling), is_stable);
}

double calm_limit(const Coupling& coupling) {
  if (coupling.scheme == Scheme::sequential || coupling.scheme == Scheme::accumulate) return scheme_limit(coupling);
  return oscillator_limit(splitting(coupling), is_calm);
}

// Damped, leapfrog's step has trace 2 - z^2 - q and determinant 1 - q with q = damping h: stable while z^2 + 2 q <= 4. The
// same share of the limit is taken for the others, whose pulses are no longer than its.
int substeps_for(double limit, double h, double frequency, double damping) {
  if (std::isinf(limit)) return 1;
  const double z = frequency * std::abs(h) / limit;  // of one sub-step; divided by n below
  const double q = damping * std::abs(h) / 2;
  // (z/n)^2 + q/n <= 1
  const double n = (q + std::sqrt(q * q + 4 * z * z)) / 2;
  return static_cast<int>(std::clamp(std::ceil(n * (1 - 1e-12)), 1.0, 1e9));
}

}  // namespace dvdx
