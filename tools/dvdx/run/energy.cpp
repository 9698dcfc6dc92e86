#include "run/energy.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ranks/agree.hpp"

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

// One of a network's, or two in one's place.
struct StoredSpring {
  std::size_t i, j;
  double stiffness, rest_length;
  double zero_length = 0;
};

// Calls use(count, spring_at) for springs that are summed one after another. Of a grid: every (down, right) neighbour of its
// particles, right of them or left.
template <class Use>
void for_each_kind(const Grid& grid, const Use& use) {
  const auto add = [&](double stiffness, std::size_t down, std::ptrdiff_t right) {
    const auto aside = static_cast<std::size_t>(std::abs(right));
    if (stiffness == 0 || down >= grid.rows || aside >= grid.columns) return;
    const auto v = static_cast<double>(down) / static_cast<double>(grid.rows - 1);
    const auto u = static_cast<double>(right) / static_cast<double>(grid.columns - 1);
    const double rest_length = std::hypot(u * grid.edge_u[0] + v * grid.edge_v[0], u * grid.edge_u[1] + v * grid.edge_v[1],
                                          u * grid.edge_u[2] + v * grid.edge_v[2]);
    const std::size_t across = grid.columns - aside;
    use((grid.rows - down) * across, [=, &grid](std::size_t n) {
      const std::size_t column = n % across + (right < 0 ? aside : 0);
      const std::size_t i = grid.first + n / across * grid.columns + column;
      const std::size_t j = i + down * grid.columns + aside - (right < 0 ? 2 * aside : 0);
      return StoredSpring{.i = i, .j = j, .stiffness = stiffness, .rest_length = rest_length};
    });
  };
  add(grid.structural, 0, 1);
  add(grid.structural, 1, 0);
  add(grid.shear, 1, 1);
  add(grid.shear, 1, -1);
  add(grid.bend, 0, 2);
  add(grid.bend, 2, 0);
}

// Of what a network stores: in the order in which it is summed.
template <class T>
struct Stored {
  const SceneFile& file;
  const State<T>& state;
  const Held& held;
  EnergySum& sum;
  const std::vector<Pair>& torn;  // ascending

  void operator()(const Grid& grid) const {
    for_each_kind(grid, [this](std::size_t count, const auto& spring_at) { this->add_all(count, spring_at); });
  }
  void operator()(const Springs& springs) const {
    add_all(springs.pairs.size(), [&](std::size_t n) {
      const auto [i, j] = springs.pairs[n];
      return StoredSpring{
          .i = i,
          .j = j,
          .stiffness = springs.stiffness[n],
          .rest_length = springs.rest_length ? (*springs.rest_length)[n] : distance(start_of<T>(file, i), start_of<T>(file, j)),
          .zero_length = springs.zero_length[n]};
    });
  }

 private:
  template <class SpringAt>
  void add_all(std::size_t count, const SpringAt& spring_at) const {
    if (held.ranks != nullptr) return add_by_ranges(count, spring_at);
    for (std::size_t n = 0; n < count; ++n) {
      const StoredSpring spring = spring_at(n);
      if (!is_torn(spring)) add(spring, distance(vector_at(state.x, spring.i), vector_at(state.x, spring.j)), sum);
    }
  }

  // Of so many springs at a time each rank asks for the ends of some; one adds after the other.
  template <class SpringAt>
  void add_by_ranges(std::size_t count, const SpringAt& spring_at) const {
    const auto ranks = static_cast<std::size_t>(held.ranks->count());
    const std::size_t at_once = ranks << 16U;
    for (std::size_t begin = 0; begin < count; begin += at_once) {
      const Run mine = share_of(*held.ranks).of(std::min(at_once, count - begin));
      std::vector<StoredSpring> springs;
      std::vector<std::uint32_t> ends;
      for (std::size_t n = begin + mine.first; n < begin + mine.first + mine.count; ++n) {
        const StoredSpring spring = spring_at(n);
        if (is_torn(spring)) continue;
        springs.push_back(spring);
        ends.insert(ends.end(), {static_cast<std::uint32_t>(spring.i), static_cast<std::uint32_t>(spring.j)});
      }
      RangeExchange exchange(*held.ranks, file.particles.count, ends);
      std::array<std::vector<T>, 3> numbers;
      std::array<Column<T>, 3> x;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        numbers[axis].resize(ends.size());
        x[axis] = {.base = numbers[axis].data(), .capacity = ends.size()};
        exchange.from_ranges(state.x[axis], x[axis]);
      }
      sum = in_turn(*held.ranks, sum, [&](EnergySum before) {
        for (std::size_t k = 0; k < springs.size(); ++k) {
          add(springs[k], distance(vector_at(x, 2 * k), vector_at(x, 2 * k + 1)), before);
        }
        return before;
      });
    }
  }

  [[nodiscard]] bool is_torn(const StoredSpring& spring) const {
    return !torn.empty() && std::binary_search(torn.begin(), torn.end(), ascending(spring.i, spring.j));
  }
  static void add(const StoredSpring& spring, double r, EnergySum& sum) {
    sum.add(0.5 * spring.stiffness * square(r - spring.rest_length));
    if (spring.zero_length != 0) sum.add(0.5 * spring.zero_length * square(r));
  }
};

}  // namespace

template <class T>
void add_particles(const SceneFile& file, const State<T>& state, const Held& held, EnergySum& sum) {
  sum = in_turn(held.ranks, sum, [&](EnergySum before) {
    for (std::size_t k = 0; k < state.count; ++k) {
      const std::size_t i = held.first + k;
      const auto velocity = vector_at(state.v, k);
      before.add(0.5 * file.scene.mass[i] * dot(velocity, velocity));
      const Potential<T> potential{file, i, vector_at(state.x, k)};
      for (const auto& force : file.scene.forces) before.add(std::visit(potential, force));
    }
    return before;
  });
}

template <class T>
void add_networks(const SceneFile& file, std::span<const Network> networks, const State<T>& state, const Held& held,
                  EnergySum& sum) {
  for (const auto& network : networks) std::visit(Stored<T>{file, state, held, sum, torn_springs(network)}, network);
}

template <class T>
double energy(const SceneFile& file, const State<T>& state, const Held& held) {
  EnergySum sum;
  add_particles(file, state, held, sum);
  add_networks(file, file.scene.networks, state, held, sum);
  return sum.value();
}

template void add_particles(const SceneFile&, const State<float>&, const Held&, EnergySum&);
template void add_particles(const SceneFile&, const State<double>&, const Held&, EnergySum&);
template void add_networks(const SceneFile&, std::span<const Network>, const State<float>&, const Held&, EnergySum&);
template void add_networks(const SceneFile&, std::span<const Network>, const State<double>&, const Held&, EnergySum&);
template double energy(const SceneFile&, const State<float>&, const Held&);
template double energy(const SceneFile&, const State<double>&, const Held&);

}  // namespace dvdx::tool
