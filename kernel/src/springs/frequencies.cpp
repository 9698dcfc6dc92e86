#include "springs/frequencies.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "springs/sweep/sweep_scheme.hpp"

namespace dvdx {
namespace {

// The number of visits of springs in one run of Lanczos' iteration, so that a plan of a million particles is made in seconds.
constexpr double spring_visits = 4e7;
constexpr int most_lanczos_steps = 100;

enum class Direction { any, start };  // in every direction, or along each spring as it stands at the start
enum class Matrix { K, C };           // of stiffness, of damping

// y = M^-1/2 K M^-1/2 x, three numbers a particle; or with C.
class Stiffness {
 public:
  Stiffness(Matrix matrix, std::span<const JoinedPair> springs, std::span<const double> w, std::span<const Vec3> start,
            Direction direction)
      : springs_(springs), matrix_(matrix), direction_(direction) {
    for (const double inverse_mass : w) root_.push_back(std::sqrt(inverse_mass));
    if (direction == Direction::any) return;
    for (const JoinedPair& s : springs) {
      Eigen::Vector3d d;
      for (std::size_t axis = 0; axis < 3; ++axis) d[static_cast<Eigen::Index>(axis)] = start[s.b][axis] - start[s.a][axis];
      const double r = d.norm();
      n_.push_back(r > 0 ? Eigen::Vector3d(d / r) : Eigen::Vector3d::Zero());
      across_.push_back(matrix == Matrix::C ? 0.0 : (r > 0 ? std::max(0.0, 1 - s.l / r) : 1.0));
    }
  }

  [[nodiscard]] Eigen::Matrix3Xd times(const Eigen::Matrix3Xd& x) const {
    Eigen::Matrix3Xd y = Eigen::Matrix3Xd::Zero(3, x.cols());
    for (std::size_t s = 0; s < springs_.size(); ++s) {
      const std::uint32_t a = springs_[s].a;
      const std::uint32_t b = springs_[s].b;
      const double weight = matrix_ == Matrix::K ? stiffness_of(springs_[s]) : damping_of(springs_[s]);
      const Eigen::Vector3d stretch = root_[b] * x.col(b) - root_[a] * x.col(a);
      Eigen::Vector3d pull = weight * stretch;
      if (direction_ == Direction::start) {
        const double along = n_[s].dot(stretch);
        const double q = matrix_ == Matrix::K ? springs_[s].q : 0;
        pull = (weight - q) * (along * n_[s] + across_[s] * (stretch - along * n_[s])) + q * stretch;
      }
      y.col(b) += root_[b] * pull;
      y.col(a) -= root_[a] * pull;
    }
    return y;
  }

 private:
  std::span<const JoinedPair> springs_;
  Matrix matrix_;
  Direction direction_;
  std::vector<double> root_;
  std::vector<Eigen::Vector3d> n_;
  std::vector<double> across_;
};

// A scattered start vector: no symmetry of a mesh makes it orthogonal to a mode.
Eigen::Matrix3Xd scattered(std::size_t count) {
  Eigen::Matrix3Xd x(3, static_cast<Eigen::Index>(count));
  std::uint64_t state = 1;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    x.data()[i] = static_cast<double>(state >> 11) * 0x1p-52 - 1;
  }
  return x.normalized();
}

// Returns the largest eigenvalue by Lanczos' iteration, from below: to 1e-3 in some tens of steps where power iteration takes
// thousands. Returns infinity if it cannot be found.
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
    // Beyond the last direction in which the start has a part, all is rounding.
    if (!(norm > 1e-8 * *std::max_element(diagonal.begin(), diagonal.end())) || step + 1 == iterations) break;
    beside.push_back(norm);
    before = std::move(now);
    now = next / norm;
  }
  // The matrix is shifted away from 0, where the solver does not converge among the motions that stretch no spring. It is
  // scaled as the solver scales a whole matrix: the solver takes a tridiagonal one as it is.
  const double shift = *std::max_element(diagonal.begin(), diagonal.end());
  if (shift == 0) return 0;
  const auto size = static_cast<Eigen::Index>(diagonal.size());
  const Eigen::VectorXd along = Eigen::Map<const Eigen::VectorXd>(diagonal.data(), size) / shift + Eigen::VectorXd::Ones(size);
  const Eigen::VectorXd across = Eigen::Map<const Eigen::VectorXd>(beside.data(), size - 1) / shift;
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(size);
  if (solver.computeFromTridiagonal(along, across, Eigen::EigenvaluesOnly).info() != Eigen::Success) {
    return std::numeric_limits<double>::infinity();
  }
  return std::max(0.0, (solver.eigenvalues()[size - 1] - 1) * shift);
}

int affordable_iterations(std::size_t springs) {
  return static_cast<int>(
      std::clamp(spring_visits / static_cast<double>(std::max<std::size_t>(springs, 1)), 8.0, double{most_lanczos_steps}));
}

struct SumBound {
  double value = 0;
  std::uint32_t particle = 0;
  double on_diagonal = 0;  // the largest w S of one particle
};

template <class Weight>
SumBound sum_bound(std::span<const JoinedPair> springs, std::span<const double> w, const Weight& weight) {
  std::vector<double> sum(w.size(), 0);  // of their magnitudes
  std::vector<double> own(w.size(), 0);
  for (const JoinedPair& s : springs) {
    for (const std::uint32_t i : {s.a, s.b}) {
      sum[i] += std::abs(weight(s));
      own[i] += weight(s);
    }
  }
  SumBound bound;
  for (const JoinedPair& s : springs) {
    if (s.is_broken) continue;
    const double of_a = w[s.a] * sum[s.a];
    const double of_b = w[s.b] * sum[s.b];
    if (of_a + of_b > bound.value) {
      bound.value = of_a + of_b;
      bound.particle = of_a >= of_b ? s.a : s.b;
    }
    bound.on_diagonal = std::max({bound.on_diagonal, w[s.a] * own[s.a], w[s.b] * own[s.b]});
  }
  return bound;
}

double bounded(Matrix matrix, std::span<const JoinedPair> springs, std::span<const double> w, const SumBound& sums) {
  const int iterations = affordable_iterations(springs.size());
  if (iterations != most_lanczos_steps) return sums.value;
  // Lanczos' value comes from below. Two hundredths are more than it misses after this many steps.
  const Stiffness everywhere(matrix, springs, w, {}, Direction::any);
  return std::clamp(1.02 * largest_eigenvalue(everywhere, w.size(), iterations), sums.on_diagonal, sums.value);
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

// Returns the largest frequency * h up to which is_so holds.
template <class IsSo>
double oscillator_limit(const Splitting& s, const IsSo& is_so) {
  constexpr double resolution = 1e-3;
  for (double z = resolution; z < 10; z += resolution) {
    if (!is_so(oscillation(s, z))) return z - resolution;
  }
  return 10;
}

bool is_stable(const Oscillation& step) { return std::abs(step.x[0] + step.v[1]) <= 2 * (1 + 1e-12); }

// A step whose inverse is the step with -h has x[0] = v[1] and keeps  Q = x[1] v^2 - v[0] x^2.  So x^2 + v^2 swings between
// Q / x[1] and Q / -v[0].
bool is_energy_bounded(const Oscillation& step) {
  const double ratio = -step.v[0] / step.x[1];
  return is_stable(step) && ratio > 0.5 && ratio < 2;
}

// Returns the highest frequency times sub-step at which Brown's sum does not grow: the least over chains, rings and cloth
// (`dvdx stability`). The more springs a particle has, the further the frequencies of its single springs lie below the highest
// one, and the nearer all sums come to leapfrog: with 7 springs on each of 8 particles the average one and the filtered pulse
// take 2.09. The exact one grows at every step, by 1e-3 of the amplitude at 0.5.
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

bool are_isolated(std::span<const JoinedPair> springs, std::span<const double> w) {
  std::vector<bool> has_spring(w.size(), false);
  for (const JoinedPair& s : springs) {
    if (s.is_broken) continue;
    for (const std::uint32_t i : {s.a, s.b}) {
      if (w[i] != 0 && has_spring[i]) return false;
      has_spring[i] = true;
    }
  }
  return true;
}

RateBounds rate_bounds(const GridRates& grid) {
  const HighestRates rates{std::sqrt(grid.of_stiffness()), grid.of_damping()};
  return {rates, rates};
}

RateBounds rate_bounds(const ListRates& list) {
  const ListRates::Most most = list.most();
  return {.least = {std::sqrt(most.own_k), most.own_c}, .most = {std::sqrt(most.k), most.c}};
}

RateBounds rate_bounds(std::span<const JoinedPair> springs, std::span<const double> w) {
  const SumBound of_k = sum_bound(springs, w, stiffness_of);
  const SumBound of_c = sum_bound(springs, w, damping_of);
  // The matrix of k 1 has the sum of the k of a particle's springs on its diagonal: a lower limit of its largest eigenvalue.
  return {.least = {std::sqrt(of_k.on_diagonal), of_c.on_diagonal}, .most = {std::sqrt(of_k.value), of_c.value}};
}

HighestRates highest_rates(std::span<const JoinedPair> springs, std::span<const double> w) {
  const double of_k = bounded(Matrix::K, springs, w, sum_bound(springs, w, stiffness_of));
  const SumBound of_c = sum_bound(springs, w, damping_of);
  return {std::sqrt(of_k), of_c.value == 0 ? 0 : bounded(Matrix::C, springs, w, of_c)};
}

Frequencies frequencies(std::span<const JoinedPair> springs, const std::optional<HighestRates>& of_grids,
                        std::span<const double> w, std::span<const Vec3> start) {
  Frequencies found;
  if (springs.empty()) return found;
  const HighestRates highest = of_grids ? *of_grids : highest_rates(springs, w);
  const auto largest_at_start = [&](Matrix matrix) {
    return largest_eigenvalue(Stiffness(matrix, springs, w, start, Direction::start), w.size(),
                              affordable_iterations(springs.size()));
  };
  found.particle = sum_bound(springs, w, stiffness_of).particle;
  found.bound = highest.frequency;
  found.start = std::min(found.bound, std::sqrt(largest_at_start(Matrix::K)));
  if (highest.damping == 0) return found;
  found.damping = highest.damping;
  found.damping_start = std::min(found.damping, largest_at_start(Matrix::C));
  return found;
}

// Flows and pulses: Blanes and Moan, J. Comput. Appl. Math. 142 (2002) 313, table 2, S6 of order 4.
//
// Pulses of springs that damp. x stands still in a pulse, so that  v' = a(v) = M^-1 (F(x) - C v)  has the solution
//   v(b h) = v + b h phi1(-b X) a,   X = h M^-1 C,   phi1(y) = (e^y - 1)/y,   a at the pulse's start
// A step takes only some powers of X. With a0 = a, a1 = -M^-1 C a0, a2 = -M^-1 C a1
//   v += b h a0 + (b h)^2/2 a1 + beta h^3 a2,   where a1 and a2 each take one more pass over the springs that damp.
// leapfrog: without a2. The rest is O(h^3) in a step: second order, as without damping.
// fourth_order: the series has beta = b^3/6, which leaves O(b^4 X^4) in each pulse: third order. But only the six pulses
// together need be right. A pulse multiplies v by 1 - b X + b^2 X^2/2 - beta X^3, the logarithm of which is
//   -b X + (b^3/6 - beta) X^3 + (b^4/8 - b beta) X^4 + O(X^5).
// beta is the same forwards and backwards, so the commutators of these terms with the flows vanish to fourth order if
//   sum (b_k^3/6 - beta_k) = 0   and   sum (b_k^4/8 - b_k beta_k) = 0.
// The nearest to b^3/6 of all such beta is, with m = mean b_k,
//   beta_k = b_k^3/6 - S (b_k - m)/V,   V = sum (b_k - m)^2,   S = sum b_k^4/24          (sums over one half of the six)
// (S6 itself is of order 4 for any two parts, even if neither is a force of the position.)
Splitting splitting(const Coupling& coupling) {
  if (coupling.scheme == Scheme::sequential) {
    if (is_generalized_alpha(coupling)) return {{0.5, 0.5}, {1.0}, {}};
    const double theta = theta_of(coupling);
    if (theta == 1) return {{1.0}, {1.0}, {}};
    return {{theta, 1 - theta}, {1.0}, {}};
  }
  if (coupling.scheme == Scheme::fourth_order) {
    constexpr double a1 = 0.0792036964311957;
    constexpr double a2 = 0.353172906049774;
    constexpr double a3 = -0.0420650803577195;
    constexpr double a4 = 1 - 2 * (a1 + a2 + a3);
    constexpr double b1 = 0.209515106613362;
    constexpr double b2 = -0.143851773179818;
    constexpr double b3 = 0.5 - (b1 + b2);
    constexpr double m = (b1 + b2 + b3) / 3;
    constexpr double V = (b1 - m) * (b1 - m) + (b2 - m) * (b2 - m) + (b3 - m) * (b3 - m);
    constexpr double S = (b1 * b1 * b1 * b1 + b2 * b2 * b2 * b2 + b3 * b3 * b3 * b3) / 24;
    const auto beta = [](double b) { return b * b * b / 6 - S * (b - m) / V; };
    return {
        {a1, a2, a3, a4, a3, a2, a1}, {b1, b2, b3, b3, b2, b1}, {beta(b1), beta(b2), beta(b3), beta(b3), beta(b2), beta(b1)}};
  }
  return {{0.5, 0.5}, {1.0}, {}};
}

std::size_t damping_passes(const Coupling& coupling) noexcept {
  if (coupling.scheme == Scheme::leapfrog) return 1;
  return coupling.scheme == Scheme::fourth_order ? 2 : 0;
}

namespace {

// leapfrog: with E = 1 - X + X^2/2 and P = 1 - X/2, both functions of X = h M^-1 C, and Z = h^2 M^-1 K, in coordinates in which
// X and Z are symmetric, two sub-steps are  x+ - x = E (x - x-) - P Z x.  An eigenvalue y with the vector x then solves
//   p y^2 - (p + e - z) y + e = 0,   p = x* P^-1 x,  e = x* P^-1 E x,  z = x* Z x
// Its roots lie within one if e <= p and 0 <= z <= 2 (p + e). For q = max X <= 2, E <= 1 and P^-1 (1 + E) =
// 2 + (X^2/2)/(1 - X/2) >= 2. So z <= 4 suffices, whichever modes q and z belong to.
// fourth_order: for one mode, z <= 3.13 and q <= 8 (radius above one by at most 2e-16, on a grid of both). If K and C have
// different modes it grows from q = 6.3 on, by up to 4e-4 a sub-step at 6.4 and 0.34 at 8. At 6.2 a search over pairs of
// matrices found no growth (tests/kernel/passes/damping_test.cpp).
double damping_limit(const Coupling& coupling) { return coupling.scheme == Scheme::fourth_order ? 6 : 2; }

}  // namespace

StableRange scheme_limit(const Coupling& coupling) {
  if (coupling.scheme == Scheme::sequential) return {};
  // A single pulse that takes the damping from the velocity before it has trace 2 - z^2 - q and determinant 1 - q. It is stable
  // while z^2 + 2 q <= 4. Brown's sums take the same rule with a limit of their own, as their pulses are no longer than this.
  if (coupling.scheme == Scheme::accumulate) return {accumulate_limit(coupling.method), 2, StableRange::Rule::together};
  return {oscillator_limit(splitting(coupling), is_stable), damping_limit(coupling)};
}

// leapfrog leaves the part E = 1 - q + q^2/2 of the speed of the most damped mode. E is one again at leapfrog's limit, and 3/4
// at 1 + sqrt(1/2). fourth_order leaves a tenth at q = 6.
StableRange bounded_energy_limit(const Coupling& coupling) {
  if (coupling.scheme == Scheme::sequential || coupling.scheme == Scheme::accumulate) return scheme_limit(coupling);
  const double damping = coupling.scheme == Scheme::leapfrog ? 1 + std::sqrt(0.5) : damping_limit(coupling);
  return {oscillator_limit(splitting(coupling), is_energy_bounded), damping};
}

namespace {

// The shares of the range that a whole step takes; one of n sub-steps takes an n-th of them.
struct Shares {
  double z = 0, q = 0;
};
Shares shares(const StableRange& range, double h, const HighestRates& rates) {
  return {rates.frequency * std::abs(h) / range.frequency, rates.damping * std::abs(h) / range.damping};
}

}  // namespace

int substeps_for(const StableRange& range, double h, const HighestRates& rates) {
  if (std::isinf(range.frequency)) return 1;
  const auto [z, q] = shares(range, h, rates);
  double n = std::max(z, q);
  if (range.rule == StableRange::Rule::together) n = (q + std::sqrt(q * q + 4 * z * z)) / 2;  // (z/n)^2 + q/n <= 1
  return static_cast<int>(std::clamp(std::ceil(n * (1 - 1e-12)), 1.0, 1e9));
}

LimitedBy limited_by(const StableRange& range, double h, const HighestRates& rates) {
  const auto [z, q] = shares(range, h, rates);
  return q > z ? LimitedBy::damping : LimitedBy::frequency;
}

}  // namespace dvdx
