#include "watch/energy.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "output/space.hpp"
#include "ranks/agree.hpp"
#include "state/stored_springs.hpp"

namespace dvdx::tool {

void EnergySum::add(double term) noexcept {
  const double next = total_ + term;
  lost_ += std::abs(total_) >= std::abs(term) ? (total_ - next) + term : (term - next) + total_;
  total_ = next;
}

// Infinities and NaN leave the compensation without meaning.
double EnergySum::value() const noexcept { return std::isfinite(total_) ? total_ + lost_ : total_; }

namespace {

double square(double value) { return value * value; }

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

// Adds the energy that a network stores, in the order of its springs.
template <class T>
struct StoredEnergy {
  const SceneFile& file;
  const State<T>& state;
  const Held& held;
  EnergySum& sum;
  const std::vector<Pair>& torn;  // ascending

  template <class Of>
  void operator()(const Of& network) const {
    for_each_kind<T>(file, network, [this](std::size_t count, const auto& spring_at) { this->add_all(count, spring_at); });
  }

 private:
  template <class SpringAt>
  void add_all(std::size_t count, const SpringAt& spring_at) const {
    if (held.ranks != nullptr) return add_by_ranges(count, spring_at);
    for (std::size_t n = 0; n < count; ++n) {
      const StoredSpring spring = spring_at(n);
      if (!is_torn(torn, spring.i, spring.j))
        add(spring, length_between(vector_at(state.x, spring.i), vector_at(state.x, spring.j)), sum);
    }
  }

  // Takes at_once springs at a time: each rank asks for the ends of some, and the ranks add one after the other.
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
        if (is_torn(torn, spring.i, spring.j)) continue;
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
          add(springs[k], length_between(vector_at(x, 2 * k), vector_at(x, 2 * k + 1)), before);
        }
        return before;
      });
    }
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
  for (const auto& network : networks) std::visit(StoredEnergy<T>{file, state, held, sum, torn_springs(network)}, network);
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
