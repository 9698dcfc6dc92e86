#include "maps/measurement.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"

namespace dvdx::tool::stability {
namespace {

constexpr double h = 1;  // s

Plan<double> compiled(const Scene& scene, const State<double>& state, Arithmetic arithmetic) {
  auto plan = compile<double>(scene, {.step = h, .arithmetic = arithmetic, .unstable = Unstable::allowed}, state);
  if (!plan) throw std::runtime_error(plan.error().message());
  return std::move(*plan);
}

void step(const Plan<double>& plan, State<double>& state, std::size_t steps) {
  if (plan.step(state, steps) != StepResult::done) throw std::runtime_error("the plan is for another state");
}

// The image of a system's starts, as a matrix, after a number of steps.
struct Look {
  Eigen::MatrixXd matrix;
  std::size_t steps = 0;
};

// The valid range of a matrix's largest element. A smaller matrix is too close to rounding. A first step is accepted in any
// case, as there is no other.
struct Range {
  double least, most;
  [[nodiscard]] bool holds(const Look& look) const {
    const double size = look.matrix.cwiseAbs().maxCoeff();
    return (size >= least || look.steps == 1) && size <= most;  // NaN is in no range
  }
};

// matrix_at(system) reads the state. The last matrix in range counts.
template <class MatrixAt>
std::vector<double> growth_of_runs(const Plan<double>& plan, State<double>& state, std::size_t systems, Range range,
                                   const MatrixAt& matrix_at) {
  std::vector<Look> looks(systems);
  std::vector<bool> is_lost(systems, false);
  std::size_t done = 0;
  for (std::size_t steps = 1; steps <= most_steps; steps *= 2) {
    step(plan, state, steps - done);
    done = steps;
    for (std::size_t k = 0; k < systems; ++k) {
      if (is_lost[k]) continue;
      Look look{matrix_at(k), steps};
      is_lost[k] = !range.holds(look);
      if (!is_lost[k]) looks[k] = std::move(look);
    }
  }
  std::vector<double> growth;
  for (const Look& look : looks) {
    growth.push_back(look.steps == 0 ? std::numeric_limits<double>::quiet_NaN()
                                     : std::pow(spectral_radius(look.matrix), 1 / static_cast<double>(look.steps)));
  }
  return growth;
}

// A damped spring has one damping for all particles, so the particle's mass sets its rate.
double mass_of(const Anchored& particle) { return particle.spring_damping > 0 ? 1 / particle.spring_damping : 1; }

Scene scene_of(std::span<const Anchored> particles, Method method) {
  Scene scene;
  scene.method = method;
  const Anchored& first = particles.front();
  std::vector<double> mass;
  std::vector<double> drag;
  for (const Anchored& particle : particles) {
    mass.push_back(mass_of(particle));
    drag.push_back(particle.drag * mass.back());
  }
  for (std::size_t j = 0; j < first.W.size(); ++j) {
    std::vector<double> stiffness;
    for (const Anchored& particle : particles) stiffness.push_back(particle.W[j] * mass_of(particle));
    scene.add(Spring{.stiffness = stiffness, .damping = j == 0 && first.spring_damping > 0 ? 1.0 : 0.0});
  }
  if (first.drag > 0) scene.add(Drag{.coefficient = std::move(drag), .expansion = first.expansion});
  scene.mass = std::move(mass);
  return scene;
}

// ---- lines -------------------------------------------------------------------------------------------------------------

constexpr double apart = 1;         // m, between neighbours at rest
constexpr double amplitude = 1e-4;  // m and m/s, of a start
// The range keeps every spring on its side of zero length, and the state well above the rounding of positions.
constexpr Range line_range{.least = 0.3, .most = 0.2 / amplitude};

// Copies of a line, one for each dimension of its relative state, each started along one of them.
struct Copies {
  std::size_t first = 0;      // index of the first particle in the batch
  std::size_t particles = 0;  // in a copy
  [[nodiscard]] std::size_t count() const { return 2 * (particles - 1); }
  [[nodiscard]] std::size_t particle(std::size_t copy, std::size_t i) const { return first + copy * particles + i; }
};

double rest_position(std::size_t i) { return apart * static_cast<double>(i); }

// One network for each damping.
struct Joined {
  Springs springs;
  std::vector<double> stiffness, rest_length;
};

void join(Joined& joined, const Line& line, const Copies& copies) {
  joined.springs.damping = line.damping;
  for (std::size_t copy = 0; copy < copies.count(); ++copy) {
    for (std::size_t s = 0; s < line.pairs.size(); ++s) {
      const auto [a, b] = line.pairs[s];
      joined.springs.pairs.push_back(
          {static_cast<std::uint32_t>(copies.particle(copy, a)), static_cast<std::uint32_t>(copies.particle(copy, b))});
      joined.stiffness.push_back(line.stiffness[s]);
      joined.rest_length.push_back(std::abs(rest_position(b) - rest_position(a)));
    }
  }
}

Scene scene_of(std::span<const Line> lines, const Coupling& coupling, const std::vector<Copies>& copies) {
  Scene scene;
  scene.coupling = coupling;
  scene.coupling.substeps = 1;
  std::vector<double> mass;
  std::map<double, Joined> by_damping;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    for (std::size_t copy = 0; copy < copies[k].count(); ++copy) {
      mass.insert(mass.end(), lines[k].mass.begin(), lines[k].mass.end());
    }
    join(by_damping[lines[k].damping], lines[k], copies[k]);
  }
  for (auto& [damping, joined] : by_damping) {
    joined.springs.stiffness = std::move(joined.stiffness);
    joined.springs.rest_length = std::move(joined.rest_length);
    scene.add(Network(std::move(joined.springs)));
  }
  scene.mass = std::move(mass);
  return scene;
}

void place(State<double>& state, const Copies& copies) {
  for (std::size_t copy = 0; copy < copies.count(); ++copy) {
    for (std::size_t i = 0; i < copies.particles; ++i) state.x[0][copies.particle(copy, i)] = rest_position(i);
    auto& column = copy < copies.particles - 1 ? state.x[0] : state.v[0];
    column[copies.particle(copy, copy % (copies.particles - 1) + 1)] += amplitude;
  }
}

Eigen::MatrixXd relative_state(const State<double>& state, const Copies& copies) {
  const auto others = static_cast<Eigen::Index>(copies.particles - 1);
  Eigen::MatrixXd matrix(2 * others, 2 * others);
  for (std::size_t copy = 0; copy < copies.count(); ++copy) {
    const std::size_t zero = copies.particle(copy, 0);
    for (std::size_t i = 1; i < copies.particles; ++i) {
      const std::size_t p = copies.particle(copy, i);
      const auto row = static_cast<Eigen::Index>(i - 1);
      const auto column = static_cast<Eigen::Index>(copy);
      matrix(row, column) = (state.x[0][p] - state.x[0][zero] - rest_position(i)) / amplitude;
      matrix(others + row, column) = (state.v[0][p] - state.v[0][zero]) / amplitude;
    }
  }
  return matrix;
}

// ---- bounces -----------------------------------------------------------------------------------------------------------

// One particle for each start; `counts` gives the number of starts of each bounce.
Scene scene_of(std::span<const Bounce> bounces, const std::vector<std::size_t>& counts) {
  Scene scene;
  const Bounce& first = bounces.front();
  if (first.pulling.gravity > 0) scene.add(Constant{.acceleration = {-first.pulling.gravity, 0, 0}});
  std::vector<double> stiffness;
  std::vector<double> drag;
  for (std::size_t k = 0; k < bounces.size(); ++k) {
    stiffness.insert(stiffness.end(), counts[k], bounces[k].pulling.W);
    drag.insert(drag.end(), counts[k], bounces[k].pulling.drag);
  }
  if (first.pulling.W > 0) scene.add(Spring{.stiffness = std::move(stiffness)});
  if (first.pulling.drag > 0) scene.add(Drag{.coefficient = std::move(drag)});
  scene.add(Contact(Plane{.normal = {1, 0, 0},
                          .restitution = first.impact.restitution,
                          .response = first.impact.response,
                          .sweep = first.impact.sweep}));
  return scene;
}

// The growth of bounces with the same restitution, which belongs to the plane.
std::vector<double> growth_of_bounces(std::span<const Bounce> bounces, Arithmetic arithmetic) {
  std::vector<Motion> starts;
  std::vector<std::size_t> counts;
  for (const Bounce& bounce : bounces) {
    const auto more = starts_of(bounce, h);
    starts.insert(starts.end(), more.begin(), more.end());
    counts.push_back(more.size());
  }
  Soa<double> memory(starts.size());
  State<double> state = memory.view();
  for (std::size_t i = 0; i < starts.size(); ++i) {
    state.x[0][i] = starts[i].x;
    state.v[0][i] = starts[i].v;
  }
  step(compiled(scene_of(bounces, counts), state, arithmetic), state, 1);
  std::vector<double> growth;
  std::size_t i = 0;
  for (std::size_t k = 0; k < bounces.size(); ++k) {
    double sum = 0;
    for (const std::size_t last = i + counts[k]; i < last; ++i) {
      const Motion end{state.x[0][i], state.v[0][i]};
      sum += energy_of(bounces[k].pulling, end) / energy_of(bounces[k].pulling, starts[i]);
    }
    growth.push_back(sum / static_cast<double>(counts[k]));
  }
  return growth;
}

}  // namespace

std::vector<double> measured_growth(std::span<const Anchored> particles, Method method, Arithmetic arithmetic) {
  Soa<double> memory(particles.size());
  State<double> state = memory.view();
  // Axes are independent: x starts with a displacement, y with a velocity.
  for (std::size_t i = 0; i < particles.size(); ++i) {
    state.x[0][i] = 1;
    state.v[1][i] = 1;
  }
  const Plan<double> plan = compiled(scene_of(particles, method), state, arithmetic);
  const auto matrix_at = [&](std::size_t i) {
    return Eigen::MatrixXd{{state.x[0][i], state.x[1][i]}, {state.v[0][i], state.v[1][i]}};
  };
  return growth_of_runs(plan, state, particles.size(), {.least = 1e-200, .most = 1e200}, matrix_at);
}

std::vector<double> measured_growth(std::span<const Line> lines, const Coupling& coupling, Arithmetic arithmetic) {
  std::vector<Copies> copies;
  std::size_t count = 0;
  for (const Line& line : lines) {
    copies.push_back({.first = count, .particles = line.mass.size()});
    count += copies.back().count() * line.mass.size();
  }
  Soa<double> memory(count);
  State<double> state = memory.view();
  for (const Copies& each : copies) place(state, each);
  const Plan<double> plan = compiled(scene_of(lines, coupling, copies), state, arithmetic);
  const auto matrix_at = [&](std::size_t k) { return relative_state(state, copies[k]); };
  return growth_of_runs(plan, state, lines.size(), line_range, matrix_at);
}

std::vector<double> measured_growth(std::span<const Bounce> bounces, Arithmetic arithmetic) {
  std::vector<double> growth;
  while (!bounces.empty()) {
    const double restitution = bounces.front().impact.restitution;
    const auto other = std::find_if(bounces.begin(), bounces.end(),
                                    [&](const Bounce& bounce) { return bounce.impact.restitution != restitution; });
    const auto alike = static_cast<std::size_t>(other - bounces.begin());
    for (const double each : growth_of_bounces(bounces.first(alike), arithmetic)) growth.push_back(each);
    bounces = bounces.subspan(alike);
  }
  return growth;
}

}  // namespace dvdx::tool::stability
