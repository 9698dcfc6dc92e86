// The springs of a scene's networks, one by one, as the file lists them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <variant>
#include <vector>

#include "dvdx/layouts/state.hpp"
#include "dvdx/scene.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

template <class T>
[[nodiscard]] Vec3 vector_at(const std::array<Column<T>, 3>& columns, std::size_t i) {
  return {static_cast<double>(columns[0][i]), static_cast<double>(columns[1][i]), static_cast<double>(columns[2][i])};
}
[[nodiscard]] inline double length_between(const Vec3& a, const Vec3& b) {
  return std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
}

// Returns a particle's start as the state held it, rounded to T.
template <class T>
[[nodiscard]] Vec3 start_of(const SceneFile& file, std::size_t particle) {
  auto start = value_of(file.particles.position, particle);
  for (double& x : start) x = static_cast<double>(static_cast<T>(x));
  return start;
}

[[nodiscard]] inline Pair ascending(std::size_t i, std::size_t j) {
  return {static_cast<std::uint32_t>(std::min(i, j)), static_cast<std::uint32_t>(std::max(i, j))};
}

// Returns the torn springs in ascending order, each with its lesser end first.
[[nodiscard]] inline std::vector<Pair> torn_springs(const Network& network) {
  std::vector<Pair> torn = std::visit([](const auto& of) { return of.broken; }, network);
  for (Pair& ends : torn) ends = ascending(ends[0], ends[1]);
  std::sort(torn.begin(), torn.end());
  return torn;
}
[[nodiscard]] inline bool is_torn(const std::vector<Pair>& torn, std::size_t i, std::size_t j) {
  return !torn.empty() && std::binary_search(torn.begin(), torn.end(), ascending(i, j));
}

// A spring of a network. zero_length: the stiffness, N/m, of a second spring beside it, of no rest length; 0: none.
struct StoredSpring {
  std::size_t i, j;
  double stiffness, rest_length;
  double zero_length = 0;
};

// Calls use(count, spring_at) for each kind of springs in turn. In a grid a kind joins particles to their neighbour (down,
// right), which is right of them or left.
template <class T, class Use>
void for_each_kind(const SceneFile& /*file*/, const Grid& grid, const Use& use) {
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
template <class T, class Use>
void for_each_kind(const SceneFile& file, const Springs& springs, const Use& use) {
  use(springs.pairs.size(), [&](std::size_t n) {
    const auto [i, j] = springs.pairs[n];
    return StoredSpring{.i = i,
                        .j = j,
                        .stiffness = springs.stiffness[n],
                        .rest_length = springs.rest_length ? (*springs.rest_length)[n]
                                                           : length_between(start_of<T>(file, i), start_of<T>(file, j)),
                        .zero_length = springs.zero_length[n]};
  });
}

}  // namespace dvdx::tool
