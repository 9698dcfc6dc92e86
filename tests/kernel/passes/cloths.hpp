// Scenes with joined particles, and their starts.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/layouts/state.hpp"
#include "dvdx/scene.hpp"

namespace dvdx::test {

struct Joined {
  std::string name;
  Scene scene;
  std::vector<Vec3> x, v;  // at the start
  double step = 1.0 / 60;
};

template <class T>
void place(const Joined& joined, State<T>& state) {
  for (std::size_t i = 0; i < state.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state.x[axis][i] = static_cast<T>(joined.x[i][axis]);
      state.v[axis][i] = static_cast<T>(joined.v[i][axis]);
    }
  }
}

// A number from -1 to 1 that depends on its arguments only.
inline double scatter(std::size_t i, std::size_t k) {
  std::uint64_t z = (i * 3 + k + 1) * 0x9E3779B97F4A7C15U;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1;
}

// A sheet of one metre by one, hung by the corners of its first row, slightly crumpled and moving.
inline Joined sheet(std::size_t rows, std::size_t columns, double k, double damping = 0) {
  Joined joined;
  Grid grid{.rows = rows, .columns = columns, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .structural = k, .shear = k / 2};
  grid.damping = damping;
  for (std::size_t i = 0; i < rows * columns; ++i) {
    const double u = static_cast<double>(i % columns) / static_cast<double>(columns - 1);
    const double w = static_cast<double>(i / columns) / static_cast<double>(rows - 1);
    joined.x.push_back({u + 0.003 * scatter(i, 0), 0.01 * scatter(i, 1), w + 0.003 * scatter(i, 2)});
    joined.v.push_back({0.1 * scatter(i, 3), 0.1 * scatter(i, 4), 0.1 * scatter(i, 5)});
  }
  joined.name = std::to_string(rows) + " x " + std::to_string(columns);
  joined.scene.mass = 0.3 / static_cast<double>(rows * columns);
  joined.scene.add(Constant{.acceleration = {0, -9.81, 0}});
  joined.scene.add(Network(grid));
  joined.scene.fixed = {0, columns - 1};
  return joined;
}

// The same with its springs as a list.
inline Joined as_list(Joined joined) {
  joined.scene.networks[0] = springs_of(std::get<Grid>(joined.scene.networks[0]));
  joined.name += ", as a list";
  return joined;
}

// The same with a weak spring across. Sweeps then find no sheet and take the springs in colours, not in strands.
inline Joined with_spring_across(Joined list) {
  auto& springs = std::get<Springs>(list.scene.networks[0]);
  const auto end = [&](std::size_t n) { return static_cast<std::uint32_t>(n * (list.x.size() - 1) / 7); };
  springs.stiffness.make_each(springs.pairs.size());
  std::vector<double> k = springs.stiffness.each();
  std::vector<double> l = springs.rest_length->each();
  springs.pairs.push_back({end(1), end(6)});
  k.push_back(0.1);
  l.push_back(0.5);
  springs.stiffness = Scalars(std::move(k));
  springs.rest_length = Scalars(std::move(l));
  list.name += ", a spring across";
  return list;
}

// The new place of each particle of a batch.
inline std::vector<std::uint32_t> shuffled(std::size_t count) {
  std::vector<std::uint32_t> place(count);
  std::iota(place.begin(), place.end(), 0U);
  for (std::size_t i = count; i-- > 1;) {
    std::swap(place[i], place[static_cast<std::size_t>(0.5 * (1 + scatter(i, 7)) * static_cast<double>(i))]);
  }
  return place;
}

// A list of springs with its particles in another order.
inline Joined in_order(const Joined& list, const std::vector<std::uint32_t>& place) {
  Joined moved = list;
  for (std::size_t i = 0; i < place.size(); ++i) {
    moved.x[place[i]] = list.x[i];
    moved.v[place[i]] = list.v[i];
  }
  for (std::size_t& i : moved.scene.fixed) i = place[i];
  std::sort(moved.scene.fixed.begin(), moved.scene.fixed.end());
  for (auto& [a, b] : std::get<Springs>(moved.scene.networks[0]).pairs) {
    a = place[a];
    b = place[b];
  }
  for (auto& [a, b] : std::get<Springs>(moved.scene.networks[0]).broken) {
    a = place[a];
    b = place[b];
  }
  for (Triangle& triangle : std::get<Springs>(moved.scene.networks[0]).triangles) {
    for (auto& i : triangle) i = place[i];
  }
  if (!list.scene.mass.is_uniform()) {
    for (std::size_t i = 0; i < place.size(); ++i) moved.scene.mass.set(place[i], list.scene.mass[i]);
  }
  moved.name += ", shuffled";
  return moved;
}

// New places that keep the first particle: a walk begins at the corner with the least index.
inline std::vector<std::uint32_t> shuffled_behind_first(std::size_t count) {
  std::vector<std::uint32_t> place = shuffled(count);
  std::swap(place[0], *std::find(place.begin(), place.end(), 0U));
  return place;
}

// The numbers, six for each particle, of a batch whose particle i has moved to place[i].
template <class T>
std::vector<T> in_order(const std::vector<T>& numbers, const std::vector<std::uint32_t>& place) {
  std::vector<T> moved(numbers.size());
  for (std::size_t i = 0; i < place.size(); ++i) {
    for (std::size_t k = 0; k < 6; ++k) moved[6 * place[i] + k] = numbers[6 * i + k];
  }
  return moved;
}

// Every scheme for springs, including one whose sweeps carry data from step to step and one whose sweeps do not.
inline std::vector<Coupling> couplings() {
  return {{.scheme = Scheme::leapfrog},
          {.scheme = Scheme::fourth_order},
          {.scheme = Scheme::sequential, .substeps = 4},
          {.scheme = Scheme::sequential, .substeps = 4, .theta = 1, .sweeps = SweepOrder::forward},
          {.scheme = Scheme::accumulate, .method = Method::combined}};
}

}  // namespace dvdx::test
