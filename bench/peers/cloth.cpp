#include "peers/cloth.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "peers/plain_sheet.hpp"

namespace dvdx::bench {
namespace {

double distance(const std::vector<double>& x, std::size_t n, const Edge& edge) {
  return std::hypot(x[edge.b] - x[edge.a], x[n + edge.b] - x[n + edge.a], x[2 * n + edge.b] - x[2 * n + edge.a]);
}

void place(Cloth& cloth) {
  const std::size_t n = cloth.nodes();
  const auto last = static_cast<double>(cloth.size - 1);
  cloth.start = {std::vector<double>(3 * n), std::vector<double>(3 * n)};
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t at_row = i / cloth.size, at_column = i % cloth.size;
    const auto row = static_cast<double>(at_row), column = static_cast<double>(at_column);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cloth.start.x[axis * n + i] = (column * cloth.edge_u[axis] + row * cloth.edge_v[axis]) / last;
    }
  }
}

void join(Cloth& cloth) {
  const std::size_t size = cloth.size;
  const double straight = cloth.spacing(), diagonal = straight * std::numbers::sqrt2;
  const auto add = [&](std::size_t a, std::size_t b, double rest) {
    cloth.edges.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), rest});
  };
  for (std::size_t row = 0; row < size; ++row) {
    for (std::size_t column = 0; column < size; ++column) {
      const std::size_t i = row * size + column;
      const bool has_right = column + 1 < size, has_below = row + 1 < size;
      if (has_right) add(i, i + 1, straight);
      if (has_below) add(i, i + size, straight);
      if (has_right && has_below) add(i, i + size + 1, diagonal);
      if (has_right && has_below) add(i + 1, i + size, diagonal);
    }
  }
}

void fix(Cloth& cloth) {
  cloth.inverse_mass.assign(cloth.nodes(), 1 / cloth.node_mass());
  if (cloth.scene == 'H') {
    cloth.fixed = {0, cloth.size - 1};
  } else {
    for (std::size_t column = 0; column < cloth.size; ++column) cloth.fixed.push_back(column);
  }
  for (const std::size_t i : cloth.fixed) cloth.inverse_mass[i] = 0;
}

// Returns the force divided by the mass with which springs at rest resist small displacements p: (M^-1 K p)_i.
std::vector<double> stiffened(const Cloth& cloth, const std::vector<double>& p) {
  const std::size_t n = cloth.nodes();
  std::vector<double> result(3 * n);
  for (const Edge& edge : cloth.edges) {
    std::array<double, 3> direction{};
    double along = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double* x = &cloth.start.x[axis * n];
      direction[axis] = (x[edge.b] - x[edge.a]) / edge.rest;
      along += direction[axis] * (p[axis * n + edge.b] - p[axis * n + edge.a]);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double force = cloth.stiffness * along * direction[axis];
      result[axis * n + edge.a] -= force * cloth.inverse_mass[edge.a];
      result[axis * n + edge.b] += force * cloth.inverse_mass[edge.b];
    }
  }
  return result;
}

// Power iteration gives a value too low by well under a percent.
double highest_frequency(const Cloth& cloth) {
  std::vector<double> p(3 * cloth.nodes());
  for (std::size_t i = 0; i < p.size(); ++i) p[i] = std::sin(1.7 * static_cast<double>(i * i));
  double square = 0;
  for (int i = 0; i < 300; ++i) {
    double before = 0, after = 0;
    std::vector<double> next = stiffened(cloth, p);
    for (const double value : p) before += value * value;
    for (const double value : next) after += value * value;
    square = std::sqrt(after / before);
    for (std::size_t j = 0; j < p.size(); ++j) p[j] = next[j] / std::sqrt(after);
  }
  return std::sqrt(square);
}

double position_error(const Cloth& cloth, const Motion& motion, const Motion& exact) {
  double sum = 0;
  for (std::size_t i = 0; i < motion.x.size(); ++i) {
    const double d = motion.x[i] - exact.x[i];
    sum += d * d;
  }
  return std::sqrt(sum / static_cast<double>(cloth.nodes())) / cloth_side;
}

// The kicks and drifts of the fourth-order splitting of Blanes and Moan (2002) for second-order equations, SRKN 6 b.
constexpr std::array<double, 3> kicks = {0.0829844064174052, 0.396309801498368, -0.0390563049223486};
constexpr std::array<double, 2> drifts = {0.245298957184271, 0.604872665711080};
constexpr std::array<double, 7> all_kicks = {kicks[0], kicks[1], kicks[2], 1 - 2 * (kicks[0] + kicks[1] + kicks[2]),
                                             kicks[2], kicks[1], kicks[0]};
constexpr std::array<double, 6> all_drifts = {drifts[0], drifts[1], 0.5 - drifts[0] - drifts[1], 0.5 - drifts[0] - drifts[1],
                                              drifts[1], drifts[0]};

struct Splitting {
  PlainSheet<double> sheet;
  Motion motion;
  std::vector<double> a = std::vector<double>(motion.x.size());

  void drift(double h) {
    for (std::size_t i = 0; i < a.size(); ++i) motion.x[i] += h * motion.v[i];
    sheet.accelerate(motion.x.data(), a.data());
  }
  void kick(double h) {
    for (std::size_t i = 0; i < a.size(); ++i) motion.v[i] += h * a[i];
  }
  void step(double h) {
    for (std::size_t stage = 0; stage < all_drifts.size(); ++stage) {
      kick(all_kicks[stage] * h);
      drift(all_drifts[stage] * h);
    }
    kick(all_kicks.back() * h);
  }
};

Motion split(const Cloth& cloth, double seconds, int substeps) {
  Splitting splitting{PlainSheet<double>(cloth), cloth.start};
  splitting.drift(0);
  const auto steps = std::lround(seconds / frame_time * substeps);
  for (long i = 0; i < steps; ++i) splitting.step(seconds / static_cast<double>(steps));
  return splitting.motion;
}

}  // namespace

Cloth make_cloth(char scene, std::size_t size, double stiffness) {
  Cloth cloth;
  cloth.scene = scene;
  cloth.size = size;
  cloth.stiffness = stiffness;
  const double tilt = std::numbers::pi / 6;
  cloth.edge_u = {cloth_side, 0, 0};
  cloth.edge_v = {0, 0, cloth_side};
  if (scene == 'C') cloth.edge_v = {0, -cloth_side * std::cos(tilt), cloth_side * std::sin(tilt)};
  place(cloth);
  join(cloth);
  fix(cloth);
  cloth.frequency = highest_frequency(cloth);
  return cloth;
}

double energy_of(const Cloth& cloth, const Motion& motion) {
  const std::size_t n = cloth.nodes();
  double energy = 0;
  for (const double v : motion.v) energy += cloth.node_mass() * v * v / 2;
  for (std::size_t i = 0; i < n; ++i) energy += cloth.node_mass() * gravity * motion.x[n + i];
  for (const Edge& edge : cloth.edges) {
    const double stretch = distance(motion.x, n, edge) - edge.rest;
    energy += cloth.stiffness * stretch * stretch / 2;
  }
  return energy;
}

Reference reference_of(const Cloth& cloth, double seconds, double tolerance) {
  constexpr int most_halvings = 4;
  Reference reference;
  reference.substeps = static_cast<int>(std::ceil(cloth.limit())) + 1;
  reference.motion = split(cloth, seconds, reference.substeps);
  for (int i = 0; i < most_halvings && (i == 0 || !(reference.change < tolerance)); ++i) {
    reference.substeps *= 2;
    Motion finer = split(cloth, seconds, reference.substeps);
    reference.change = position_error(cloth, reference.motion, finer);
    reference.motion = std::move(finer);
  }
  reference.energy = energy_of(cloth, reference.motion);
  return reference;
}

Deviation deviation_of(const Cloth& cloth, const Motion& motion, const Reference& reference) {
  return {position_error(cloth, motion, reference.motion),
          (energy_of(cloth, motion) - reference.energy) / (cloth_mass * gravity * cloth_side)};
}

}  // namespace dvdx::bench
