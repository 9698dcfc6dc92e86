#include "run/energy.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace dvdx::tool {

void EnergySum::add(double term) noexcept {
  const double next = total_ + term;
  lost_ += std::abs(total_) >= std::abs(term) ? (total_ - next) + term : (term - next) + total_;
  total_ = next;
}

// Infinities and NaN leave the compensation without meaning.
double EnergySum::value() const noexcept { return std::isfinite(total_) ? total_ + lost_ : total_; }

namespace {

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double square(double value) { return value * value; }
double distance(const Vec3& a, const Vec3& b) { return std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]); }

// As the state held it, rounded to its precision.
template <class T>
Vec3 start_of(const SceneFile& file, std::size_t particle) {
  auto start = value_of(file.particles.position, particle);
  for (double& x : start) x = static_cast<double>(static_cast<T>(x));
  return start;
}

template <class T>
struct Potential {
  const SceneFile& file;
  const State<T>& state;
  std::size_t particle;
  Vec3 position;

  [[nodiscard]] Vec3 offset(const Anchor& anchor) const {
    Vec3 from{};
    if (const auto* all = std::get_if<Vec3>(&anchor)) {
      from = *all;
    } else if (const auto* each = std::get_if<std::vector<Vec3>>(&anchor)) {
      from = (*each)[particle];
    } else {
      from = start_of<T>(file, particle);
    }
    return {position[0] - from[0], position[1] - from[1], position[2] - from[2]};
  }

  double operator()(const Constant& force) const { return -file.scene.mass[particle] * dot(force.acceleration, position); }
  double operator()(const Spring& force) const {
    const auto e = offset(force.anchor);
    double twice = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) twice += force.stiffness.at(axis, particle) * square(e[axis]);
    return 0.5 * twice;
  }
  double operator()(const RadialSpring& force) const {
    const auto e = offset(force.anchor);
    return 0.5 * force.stiffness[particle] * square(std::hypot(e[0], e[1], e[2]) - force.rest_length[particle]);
  }
  double operator()(const Polynomial& /*force*/) const { return 0; }
  double operator()(const Sinusoid& /*force*/) const { return 0; }
  double operator()(const Drag& /*force*/) const { return 0; }
};

template <class T>
Vec3 vector_at(const std::array<Column<T>, 3>& columns, std::size_t i) {
  return {static_cast<double>(columns[0][i]), static_cast<double>(columns[1][i]), static_cast<double>(columns[2][i])};
}

Pair ascending(std::size_t i, std::size_t j) {
  return {static_cast<std::uint32_t>(std::min(i, j)), static_cast<std::uint32_t>(std::max(i, j))};
}

std::vector<Pair> torn_springs(const Network& network) {
  std::vector<Pair> torn = std::visit([](const auto& of) { return of.broken; }, network);
  for (Pair& ends : torn) ends = ascending(ends[0], ends[1]);
  std::sort(torn.begin(), torn.end());
  return torn;
}

// Of the whole springs of networks.
template <class T>
struct Stored {
  const SceneFile& file;
  const State<T>& state;
  EnergySum& sum;
  const std::vector<Pair>& torn;  // ascending

  void add(std::size_t i, std::size_t j, double stiffness, double rest_length) const {
    if (!torn.empty() && std::binary_search(torn.begin(), torn.end(), ascending(i, j))) return;
    const double r = distance(vector_at(state.x, i), vector_at(state.x, j));
    sum.add(0.5 * stiffness * square(r - rest_length));
  }

  // Every (down, right) neighbour of a grid's particles, right of them or left.
  void add(const Grid& grid, double stiffness, std::size_t down, std::ptrdiff_t right) const {
    if (stiffness == 0 || down >= grid.rows) return;
    const auto v = static_cast<double>(down) / static_cast<double>(grid.rows - 1);
    const auto u = static_cast<double>(right) / static_cast<double>(grid.columns - 1);
    const double rest_length = std::hypot(u * grid.edge_u[0] + v * grid.edge_v[0], u * grid.edge_u[1] + v * grid.edge_v[1],
                                          u * grid.edge_u[2] + v * grid.edge_v[2]);
    const auto columns = static_cast<std::ptrdiff_t>(grid.columns);
    for (std::size_t r = 0; r + down < grid.rows; ++r) {
      for (auto c = std::max<std::ptrdiff_t>(0, -right); c < columns - std::max<std::ptrdiff_t>(0, right); ++c) {
        const auto i = grid.first + r * grid.columns + static_cast<std::size_t>(c);
        const auto j = grid.first + (r + down) * grid.columns + static_cast<std::size_t>(c + right);
        add(i, j, stiffness, rest_length);
      }
    }
  }

  void operator()(const Grid& grid) const {
    add(grid, grid.structural, 0, 1);
    add(grid, grid.structural, 1, 0);
    add(grid, grid.shear, 1, 1);
    add(grid, grid.shear, 1, -1);
    add(grid, grid.bend, 0, 2);
    add(grid, grid.bend, 2, 0);
  }
  void operator()(const Springs& springs) const {
    for (std::size_t n = 0; n < springs.pairs.size(); ++n) {
      const auto [i, j] = springs.pairs[n];
      const double rest_length =
          springs.rest_length ? (*springs.rest_length)[n] : distance(start_of<T>(file, i), start_of<T>(file, j));
      add(i, j, springs.stiffness[n], rest_length);
      if (springs.zero_length[n] != 0) add(i, j, springs.zero_length[n], 0);
    }
  }
};

}  // namespace

template <class T>
void add_particles(const SceneFile& file, const State<T>& state, EnergySum& sum) {
  for (std::size_t i = 0; i < state.count; ++i) {
    const auto velocity = vector_at(state.v, i);
    sum.add(0.5 * file.scene.mass[i] * dot(velocity, velocity));
    const Potential<T> potential{file, state, i, vector_at(state.x, i)};
    for (const auto& force : file.scene.forces) sum.add(std::visit(potential, force));
  }
}

template <class T>
void add_networks(const SceneFile& file, std::span<const Network> networks, const State<T>& state, EnergySum& sum) {
  for (const auto& network : networks) std::visit(Stored<T>{file, state, sum, torn_springs(network)}, network);
}

template <class T>
double energy(const SceneFile& file, const State<T>& state) {
  EnergySum sum;
  add_particles(file, state, sum);
  add_networks(file, file.scene.networks, state, sum);
  return sum.value();
}

template void add_particles(const SceneFile&, const State<float>&, EnergySum&);
template void add_particles(const SceneFile&, const State<double>&, EnergySum&);
template void add_networks(const SceneFile&, std::span<const Network>, const State<float>&, EnergySum&);
template void add_networks(const SceneFile&, std::span<const Network>, const State<double>&, EnergySum&);
template double energy(const SceneFile&, const State<float>&);
template double energy(const SceneFile&, const State<double>&);

}  // namespace dvdx::tool
