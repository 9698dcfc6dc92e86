#include "closed_form/closed_form.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "closed_form/balls.hpp"

namespace dvdx::tool {
namespace {

// --- Affine scenes -----------------------------------------------------------------------------------------------------------
// With the forcings as states, the equation of an axis is linear with constant coefficients:
//   y = (x, v, 1, t, t^2/2!, ..., A sin, A cos, ...),   y' = M y,   y(t) = exp(M t) y(0).
// exp(M t) - I comes from a Taylor series over t / 2^s and s doublings, exp(2 X) - I = 2 E + E^2 with E = exp(X) - I. E does
// not contain the identity, which keeps the small entries of stiff and of slow systems. There are no special cases: critical
// damping, resonance, no spring and no drag need no branch. Error: about sqrt(W) t units in the last place.
class Matrix {
 public:
  explicit Matrix(std::size_t size) : size_(size), values_(size * size) {}

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  long double& operator()(std::size_t row, std::size_t column) { return values_[row * size_ + column]; }
  long double operator()(std::size_t row, std::size_t column) const { return values_[row * size_ + column]; }

  // this += factor * other
  void add(const Matrix& other, long double factor) {
    for (std::size_t i = 0; i < values_.size(); ++i) values_[i] += factor * other.values_[i];
  }

  friend Matrix operator*(const Matrix& a, const Matrix& b) {
    Matrix product(a.size_);
    for (std::size_t row = 0; row < a.size_; ++row) {
      for (std::size_t k = 0; k < a.size_; ++k) {
        const long double factor = a(row, k);
        if (factor == 0) continue;  // most are zero
        for (std::size_t column = 0; column < a.size_; ++column) product(row, column) += factor * b(k, column);
      }
    }
    return product;
  }

 private:
  std::size_t size_;
  std::vector<long double> values_;
};

constexpr std::size_t position = 0;
constexpr std::size_t velocity = 1;
constexpr std::size_t first_forcing = 2;

Matrix generator(const AxisEquation& equation) {
  const std::size_t powers = equation.polynomial.size();
  Matrix m(first_forcing + powers + 2 * equation.sines.size());
  m(position, velocity) = 1;
  m(velocity, position) = -equation.W;
  m(velocity, velocity) = -equation.g;
  long double factorial = 1;
  for (std::size_t k = 0; k < powers; ++k) {
    if (k > 0) {
      factorial *= static_cast<long double>(k);
      m(first_forcing + k, first_forcing + k - 1) = 1;  // (t^k/k!)' = t^(k-1)/(k-1)!
    }
    m(velocity, first_forcing + k) = equation.polynomial[k] * factorial;
  }
  for (std::size_t j = 0; j < equation.sines.size(); ++j) {
    const std::size_t sine = first_forcing + powers + 2 * j;
    m(velocity, sine) = 1;
    m(sine, sine + 1) = equation.sines[j].angular_frequency;
    m(sine + 1, sine) = -equation.sines[j].angular_frequency;
  }
  return m;
}

std::vector<long double> full_state(const AxisEquation& equation, AxisState start) {
  std::vector<long double> y{start.x, start.v};
  for (std::size_t k = 0; k < equation.polynomial.size(); ++k) y.push_back(k == 0 ? 1.0L : 0.0L);
  for (const auto& sine : equation.sines) {
    y.push_back(sine.amplitude * std::sin(sine.phase));
    y.push_back(sine.amplitude * std::cos(sine.phase));
  }
  return y;
}

// exp(M t) - I
Matrix flow_less_identity(const AxisEquation& equation, long double t) {
  long double fastest = std::max(std::sqrt(std::abs(equation.W)), std::abs(equation.g));
  for (const auto& sine : equation.sines) fastest = std::max(fastest, std::abs(sine.angular_frequency));
  const int doublings = std::max(0, std::ilogb(fastest * std::abs(t) + 1e-30L) + 2);  // fastest * tau < 1/2

  const Matrix m = generator(equation);
  const long double tau = std::ldexp(t, -doublings);
  Matrix term(m.size());
  term.add(m, tau);
  Matrix flow = term;
  constexpr int terms = 24;  // (1/2)^24 / 24! is far below a unit in the last place
  for (int k = 2; k <= terms; ++k) {
    Matrix next(m.size());
    next.add(term * m, tau / static_cast<long double>(k));
    term = std::move(next);
    flow.add(term, 1);
  }
  for (int i = 0; i < doublings; ++i) {
    Matrix doubled = flow * flow;
    doubled.add(flow, 2);
    flow = std::move(doubled);
  }
  return flow;
}

std::vector<long double> moved(const Matrix& flow, const std::vector<long double>& y) {
  auto next = y;
  for (std::size_t row = 0; row < y.size(); ++row) {
    long double change = 0;
    for (std::size_t column = 0; column < y.size(); ++column) change += flow(row, column) * y[column];
    next[row] += change;
  }
  return next;
}

// An axis of a particle. Positions are counted from `origin`, so that a distant anchor costs no digits.
struct AxisProblem {
  AxisEquation equation;
  AxisState start;
  long double origin = 0;
};

class AxisBuilder {
 public:
  AxisBuilder(const SceneFile& file, std::size_t particle, std::size_t axis)
      : file_(file), particle_(particle), axis_(axis), mass_(file.scene.mass[particle]) {
    const long double start = value_of(file.particles.position, particle)[axis];
    problem_.origin = start;
    for (const auto& force : file.scene.forces) {
      if (const auto* spring = std::get_if<Spring>(&force)) {
        problem_.origin = anchor(spring->anchor);
        break;
      }
    }
    problem_.start = {start - problem_.origin, value_of(file.particles.velocity, particle)[axis]};
    problem_.equation.polynomial.assign(1, 0);
    for (const auto& force : file.scene.forces) std::visit([this](const auto& each) { add(each); }, force);
  }

  [[nodiscard]] const AxisProblem& problem() const { return problem_; }

 private:
  [[nodiscard]] long double anchor(const Anchor& anchor) const {
    if (const auto* all = std::get_if<Vec3>(&anchor)) return (*all)[axis_];
    if (const auto* each = std::get_if<std::vector<Vec3>>(&anchor)) return (*each)[particle_][axis_];
    return value_of(file_.particles.position, particle_)[axis_];
  }
  void add_polynomial(std::size_t power, long double acceleration) {
    auto& polynomial = problem_.equation.polynomial;
    if (polynomial.size() <= power) polynomial.resize(power + 1);
    polynomial[power] += acceleration;
  }
  void add(const Constant& force) { add_polynomial(0, force.acceleration[axis_]); }
  void add(const Polynomial& force) {
    for (std::size_t k = 0; k < force.acceleration.size(); ++k) add_polynomial(k, force.acceleration[k][axis_]);
  }
  void add(const Sinusoid& force) {
    if (force.acceleration[axis_] == 0) return;
    problem_.equation.sines.push_back({force.acceleration[axis_], force.angular_frequency, force.phase});
  }
  void add(const Spring& force) {
    const long double W = force.stiffness.at(axis_, particle_) / mass_;
    problem_.equation.W += W;
    problem_.equation.g += force.damping / mass_;
    add_polynomial(0, W * (anchor(force.anchor) - problem_.origin));
  }
  void add(const Drag& force) {
    const long double g = force.coefficient.at(axis_, particle_) / mass_;
    problem_.equation.g += g;
    add_polynomial(0, g * force.wind[axis_]);
  }
  void add(const RadialSpring& /*force*/) {}  // closed_form_of rejects these

  const SceneFile& file_;
  std::size_t particle_;
  std::size_t axis_;
  long double mass_;
  AxisProblem problem_;
};

bool is_fixed(const SceneFile& file, std::size_t particle) {
  const auto& fixed = file.scene.fixed;
  return std::find(fixed.begin(), fixed.end(), particle) != fixed.end();
}

// The flows from one sample time to the next. A run has few different ones, and particles that are alike share them.
class Flows {
 public:
  explicit Flows(double unit) : unit_(unit) {}

  const Matrix& over(const AxisEquation& equation, std::uint64_t count) {
    if (!(equation == equation_)) flows_.clear();
    equation_ = equation;
    for (const auto& [known, flow] : flows_) {
      if (known == count) return flow;
    }
    return flows_
        .emplace_back(count, flow_less_identity(equation, static_cast<long double>(unit_) * static_cast<long double>(count)))
        .second;
  }

 private:
  long double unit_;
  AxisEquation equation_;
  std::vector<std::pair<std::uint64_t, Matrix>> flows_;
};

void follow_axis(const AxisProblem& problem, Flows& flows, std::span<const std::uint64_t> counts, std::size_t particle,
                 std::size_t axis, Path& path) {
  auto y = full_state(problem.equation, problem.start);
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (k > 0) y = moved(flows.over(problem.equation, counts[k] - counts[k - 1]), y);
    path.x[path.index(k, particle, axis)] = problem.origin + y[position];
    path.v[path.index(k, particle, axis)] = y[velocity];
  }
}

// --- One wall ----------------------------------------------------------------------------------------------------------------
AxisState flight(AxisState start, long double a, long double t) {
  return {start.x + t * (start.v + t * (a / 2)), start.v + a * t};
}

// Returns the time until s = 0 with an inward speed; none if that never happens.
std::optional<long double> impact(AxisState start, long double a) {
  const long double discriminant = start.v * start.v - 2 * a * start.x;
  if (discriminant < 0) return std::nullopt;
  const long double root = std::sqrt(discriminant);
  // s + v t + a t^2/2 crosses zero downwards where the speed is -root: t = (-root - v)/a = 2 s/(root - v).
  if (start.v < 0) return 2 * start.x / (root - start.v);
  if (a < 0) return (-root - start.v) / a;
  return std::nullopt;
}

// The motion after an impact with speed u outwards, under acceleration -b towards the wall: successive flights of 2 u e^k / b.
AxisState bouncing(long double u, long double b, long double e, long double t) {
  const long double first = 2 * u / b;
  if (e == 1) {
    const long double since = std::fmod(t, first);
    return flight({0, u}, -b, since);
  }
  if (e == 0 || u == 0 || t * (1 - e) >= first) return {};  // at rest
  // Flight k starts at first (1 - e^k)/(1 - e).
  const auto begins = [&](long double k) { return -first * std::expm1(k * std::log(e)) / (1 - e); };
  long double k = std::floor(std::log1p(-t * (1 - e) / first) / std::log(e));
  while (begins(k) > t) --k;
  while (begins(k + 1) <= t) ++k;
  const auto state = flight({0, u * std::pow(e, k)}, -b, t - begins(k));
  return {std::max(state.x, 0.0L), state.v};
}

struct BounceProblem {
  BounceEquation equation;
  std::array<long double, 3> normal{};
  std::array<long double, 3> acceleration{};
  AxisState start;  // relative to the wall
};

long double dot(const std::array<long double, 3>& a, const Vec3& b) {
  long double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) sum += a[axis] * static_cast<long double>(b[axis]);
  return sum;
}

BounceProblem bounce_problem(const SceneFile& file, std::size_t particle) {
  BounceProblem problem;
  const auto& plane = std::get<Plane>(file.scene.contacts.front());
  for (std::size_t axis = 0; axis < 3; ++axis) problem.normal[axis] = plane.normal[axis];
  const long double length = std::sqrt(dot(problem.normal, plane.normal));
  for (auto& each : problem.normal) each /= length;
  for (const auto& force : file.scene.forces) {
    const auto& constant = std::get<Constant>(force);
    problem.equation.acceleration += dot(problem.normal, constant.acceleration);
    for (std::size_t axis = 0; axis < 3; ++axis) problem.acceleration[axis] += constant.acceleration[axis];
  }
  problem.equation.restitution = plane.restitution;
  problem.start = {dot(problem.normal, value_of(file.particles.position, particle)) - plane.offset - plane.thickness,
                   dot(problem.normal, value_of(file.particles.velocity, particle))};
  return problem;
}

std::vector<AxisState> bounce_state(const SceneFile& file, std::size_t particle, long double t) {
  const auto problem = bounce_problem(file, particle);
  const auto across = solve(problem.equation, problem.start, t);
  // The wall acts along its normal only. The tangential motion is a free flight.
  const auto free_across = flight(problem.start, problem.equation.acceleration, t);
  const auto x = value_of(file.particles.position, particle);
  const auto v = value_of(file.particles.velocity, particle);
  std::vector<AxisState> state(3);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    state[axis] = flight({x[axis], v[axis]}, problem.acceleration[axis], t);
    state[axis].x += problem.normal[axis] * (across.x - free_across.x);
    state[axis].v += problem.normal[axis] * (across.v - free_across.v);
  }
  return state;
}

bool is_bounce(const SceneFile& file) {
  const auto& scene = file.scene;
  if (scene.contacts.size() != 1 || !scene.fixed.empty()) return false;
  const auto is_constant = [](const Force& force) { return std::holds_alternative<Constant>(force); };
  if (!std::all_of(scene.forces.begin(), scene.forces.end(), is_constant)) return false;
  const auto* plane = std::get_if<Plane>(&scene.contacts.front());
  if (plane == nullptr || plane->friction != 0 || plane->viscosity != 0 || plane->normal_viscosity != 0) return false;
  for (std::size_t i = 0; i < file.particles.count; ++i) {
    if (bounce_problem(file, i).start.x < 0) return false;  // the motion inside depends on the contact's law
  }
  return true;
}

// --- Two bodies on one spring ------------------------------------------------------------------------------------------------
// The centre of mass flies freely. The distance r oscillates: r'' = -k (1/m0 + 1/m1) (r - rest length).
std::array<Vec3, 2> each_start(const Vectors& vectors) { return {value_of(vectors, 0), value_of(vectors, 1)}; }

struct PairProblem {
  AxisEquation equation;
  AxisState start;  // r - rest length
  long double rest_length = 0;
  std::array<long double, 3> line{};    // unit vector from particle 0 to particle 1
  std::array<long double, 2> shares{};  // the share of r that each body's distance from the centre of mass takes
  std::array<AxisState, 3> centre{};
  std::array<long double, 3> acceleration{};
};

using LongVector = std::array<long double, 3>;

LongVector between(const Vec3& from, const Vec3& to) {
  LongVector way{};
  for (std::size_t axis = 0; axis < 3; ++axis) way[axis] = static_cast<long double>(to[axis]) - from[axis];
  return way;
}

long double length(const LongVector& v) { return std::hypot(v[0], v[1], v[2]); }

PairProblem pair_problem(const SceneFile& file) {
  PairProblem problem;
  const auto& springs = std::get<Springs>(file.scene.networks.front());
  const auto x = each_start(file.particles.position);
  const auto v = each_start(file.particles.velocity);
  const long double m0 = file.scene.mass[0];
  const long double m1 = file.scene.mass[1];
  const auto way = between(x[0], x[1]);
  const auto speed = between(v[0], v[1]);
  const long double r = length(way);
  long double away = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    problem.line[axis] = way[axis] / r;
    away += problem.line[axis] * speed[axis];
    problem.centre[axis] = {(m0 * x[0][axis] + m1 * x[1][axis]) / (m0 + m1), (m0 * v[0][axis] + m1 * v[1][axis]) / (m0 + m1)};
    for (const auto& force : file.scene.forces) problem.acceleration[axis] += std::get<Constant>(force).acceleration[axis];
  }
  problem.rest_length = springs.rest_length ? static_cast<long double>((*springs.rest_length)[0]) : r;
  problem.equation.W = springs.stiffness[0] * (1 / m0 + 1 / m1);
  problem.start = {r - problem.rest_length, away};
  problem.shares = {-m1 / (m0 + m1), m0 / (m0 + m1)};
  return problem;
}

std::vector<AxisState> pair_state(const SceneFile& file, std::size_t particle, long double t) {
  const auto problem = pair_problem(file);
  auto r = solve(problem.equation, problem.start, t);
  r.x += problem.rest_length;
  std::vector<AxisState> state(3);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const long double along = problem.shares[particle] * problem.line[axis];
    state[axis] = flight(problem.centre[axis], problem.acceleration[axis], t);
    state[axis].x += along * r.x;
    state[axis].v += along * r.v;
  }
  return state;
}

// Returns true if the two move along one line and never come so close that they meet.
bool keeps_its_line(const SceneFile& file) {
  const auto x = each_start(file.particles.position);
  const auto v = each_start(file.particles.velocity);
  const auto speed = between(v[0], v[1]);
  if (!(length(between(x[0], x[1])) > 0)) return false;
  const auto problem = pair_problem(file);
  LongVector across = speed;
  for (std::size_t axis = 0; axis < 3; ++axis) across[axis] -= problem.start.v * problem.line[axis];
  if (length(across) > 1e-15L * length(speed)) return false;
  const long double swing = std::hypot(problem.start.x, problem.start.v / std::sqrt(problem.equation.W));
  return problem.equation.W > 0 && swing < problem.rest_length;
}

bool is_pair(const SceneFile& file) {
  const auto& scene = file.scene;
  if (file.particles.count != 2 || scene.networks.size() != 1 || !scene.constraints.empty()) return false;
  if (!scene.contacts.empty() || !scene.fixed.empty()) return false;
  const auto is_constant = [](const Force& force) { return std::holds_alternative<Constant>(force); };
  if (!std::all_of(scene.forces.begin(), scene.forces.end(), is_constant)) return false;
  const auto* springs = std::get_if<Springs>(&scene.networks.front());
  return springs != nullptr && springs->pairs.size() == 1 && springs->damping == 0 && keeps_its_line(file);
}

std::vector<AxisState> resting(const SceneFile& file, std::size_t particle) {
  std::vector<AxisState> state(3);
  for (std::size_t axis = 0; axis < 3; ++axis) state[axis].x = value_of(file.particles.position, particle)[axis];
  return state;
}

void store(const std::vector<AxisState>& state, std::size_t time, std::size_t particle, Path& path) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    path.x[path.index(time, particle, axis)] = state[axis].x;
    path.v[path.index(time, particle, axis)] = state[axis].v;
  }
}

}  // namespace

AxisState solve(const AxisEquation& equation, AxisState start, long double t) {
  const auto y = moved(flow_less_identity(equation, t), full_state(equation, start));
  return {y[position], y[velocity]};
}

AxisState solve(const BounceEquation& equation, AxisState start, long double t) {
  const long double a = equation.acceleration;
  const auto first = impact(start, a);
  if (!first || *first >= t) return flight(start, a, t);
  const long double u = -equation.restitution * flight(start, a, *first).v;
  if (a < 0) return bouncing(u, -a, equation.restitution, t - *first);
  return flight({0, u}, a, t - *first);  // no force returns it to the wall
}

ClosedForm closed_form_of(const SceneFile& file) {
  const auto& scene = file.scene;
  if (has_followers(scene) || !scene.skins.empty() || !scene.tethers.empty()) return ClosedForm::none;
  if (scene.meet) return is_of_balls(file) ? ClosedForm::balls : ClosedForm::none;
  if (is_joined(scene)) return is_pair(file) ? ClosedForm::pair : ClosedForm::none;
  const auto is_radial = [](const Force& force) { return std::holds_alternative<RadialSpring>(force); };
  if (std::any_of(scene.forces.begin(), scene.forces.end(), is_radial)) return ClosedForm::none;
  if (scene.contacts.empty()) return ClosedForm::affine;
  return is_bounce(file) ? ClosedForm::bounce : ClosedForm::none;
}

Path exact_path(const SceneFile& file, double unit, std::span<const std::uint64_t> counts) {
  Path path(file.particles.count, counts.size());
  const bool is_affine = closed_form_of(file) == ClosedForm::affine;
  Flows flows(unit);
  for (std::size_t i = 0; i < path.particles; ++i) {
    if (is_affine && !is_fixed(file, i)) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        follow_axis(AxisBuilder(file, i, axis).problem(), flows, counts, i, axis, path);
      }
      continue;
    }
    for (std::size_t k = 0; k < counts.size(); ++k) {
      store(exact_state(file, i, static_cast<long double>(unit) * static_cast<long double>(counts[k])), k, i, path);
    }
  }
  return path;
}

std::vector<AxisState> exact_state(const SceneFile& file, std::size_t particle, long double t) {
  if (is_fixed(file, particle)) return resting(file, particle);
  const auto form = closed_form_of(file);
  if (form == ClosedForm::bounce) return bounce_state(file, particle, t);
  if (form == ClosedForm::pair) return pair_state(file, particle, t);
  if (form == ClosedForm::balls) return balls_state(file, particle, t);
  std::vector<AxisState> state;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto problem = AxisBuilder(file, particle, axis).problem();
    state.push_back(solve(problem.equation, problem.start, t));
    state.back().x += problem.origin;
  }
  return state;
}

}  // namespace dvdx::tool
