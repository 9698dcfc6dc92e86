#include "compile/particle_order.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "dvdx/export.h"
#include "math/vec3.hpp"
#include "passes/network/network.hpp"

namespace dvdx {
namespace {

Vec3 spanned(const Grid& grid, std::size_t down, std::ptrdiff_t right) {
  Vec3 d{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    d[axis] = static_cast<double>(right) * grid.edge_u[axis] / static_cast<double>(grid.columns - 1) +
              static_cast<double>(down) * grid.edge_v[axis] / static_cast<double>(grid.rows - 1);
  }
  return d;
}

void append(const Grid& grid, std::vector<JoinedPair>& pairs) {
  const std::vector<GridDirection> directions = directions_of(grid);
  for (std::size_t row = 0; row < grid.rows; ++row) {
    for (std::size_t column = 0; column < grid.columns; ++column) {
      const std::size_t i = row * grid.columns + column;
      for (const GridDirection& d : directions) {
        const std::ptrdiff_t other = static_cast<std::ptrdiff_t>(column) + d.right;
        if (row + d.down >= grid.rows || other < 0 || other >= static_cast<std::ptrdiff_t>(grid.columns)) continue;
        const std::size_t j = (row + d.down) * grid.columns + static_cast<std::size_t>(other);
        pairs.push_back(
            {static_cast<std::uint32_t>(grid.first + i), static_cast<std::uint32_t>(grid.first + j), d.k, d.l, grid.damping});
      }
    }
  }
}

void append(const Springs& springs, std::span<const Vec3> start, std::vector<JoinedPair>& pairs) {
  for (std::size_t s = 0; s < springs.pairs.size(); ++s) {
    const auto [a, b] = std::minmax(springs.pairs[s][0], springs.pairs[s][1]);
    const double l = springs.rest_length ? (*springs.rest_length)[s] : distance(start[a], start[b]);
    pairs.push_back({a, b, springs.stiffness[s], l, springs.damping});
  }
}

// Neighbours of each particle, ascending.
std::vector<std::vector<std::uint32_t>> neighbours(std::span<const JoinedPair> springs, std::size_t count) {
  std::vector<std::vector<std::uint32_t>> of(count);
  for (const JoinedPair& s : springs) {
    of[s.a].push_back(s.b);
    of[s.b].push_back(s.a);
  }
  for (auto& list : of) std::sort(list.begin(), list.end());
  return of;
}

// Reverse Cuthill-McKee: breadth first from a particle of few neighbours, few neighbours first (George and Liu 1981).
std::vector<std::uint32_t> near_order(std::span<const JoinedPair> springs, std::size_t count) {
  auto of = neighbours(springs, count);
  const auto degree_first = [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(of[a].size(), a) < std::pair(of[b].size(), b);
  };
  std::vector<std::uint32_t> starts(count);
  std::iota(starts.begin(), starts.end(), 0U);
  std::sort(starts.begin(), starts.end(), degree_first);
  std::vector<std::uint32_t> order;
  std::vector<bool> is_placed(count, false);
  for (const std::uint32_t root : starts) {
    if (is_placed[root]) continue;
    is_placed[root] = true;
    order.push_back(root);
    for (std::size_t next = order.size() - 1; next < order.size(); ++next) {
      std::vector<std::uint32_t> found;
      for (const std::uint32_t j : of[order[next]]) {
        if (is_placed[j]) continue;
        is_placed[j] = true;
        found.push_back(j);
      }
      std::sort(found.begin(), found.end(), degree_first);
      order.insert(order.end(), found.begin(), found.end());
    }
  }
  std::reverse(order.begin(), order.end());
  return order;
}

// Mean distance of a spring's ends in an order.
double spread(std::span<const JoinedPair> springs, std::span<const std::uint32_t> element_of) {
  double sum = 0;
  for (const JoinedPair& s : springs) {
    sum += std::abs(static_cast<double>(element_of[s.a]) - static_cast<double>(element_of[s.b]));
  }
  return springs.empty() ? 0 : sum / static_cast<double>(springs.size());
}

void fill_places(Places& places, std::size_t count) {
  places.of.resize(count);
  for (const Run& run : places.runs) {
    for (std::size_t k = 0; k < run.count; ++k) {
      places.of[run.particle + k * run.every] = static_cast<std::uint32_t>(run.element + k);
    }
  }
}

constexpr std::size_t run_length = 4096;  // particles that a thread copies at a time

std::size_t filled(std::size_t count) { return (count + slice - 1) / slice * slice; }

}  // namespace

std::vector<GridDirection> directions_of(const Grid& grid) {
  std::vector<GridDirection> directions;
  const auto add = [&](std::size_t down, std::ptrdiff_t right, double k) {
    if (k == 0) return;
    const Vec3 d = spanned(grid, down, right);
    const double l = length(d);
    directions.push_back({down, right, k, l, {d[0] / l, d[1] / l, d[2] / l}});
  };
  add(0, 1, grid.structural);
  add(0, 2, grid.bend);
  add(1, -1, grid.shear);
  add(1, 0, grid.structural);
  add(1, 1, grid.shear);
  add(2, 0, grid.bend);
  return directions;
}

DVDX_EXPORT Springs springs_of(const Grid& grid) {
  std::vector<JoinedPair> joined;
  append(grid, joined);
  std::sort(joined.begin(), joined.end(),
            [](const JoinedPair& s, const JoinedPair& t) { return std::pair(s.a, s.b) < std::pair(t.a, t.b); });
  Springs springs;
  std::vector<double> stiffness;
  std::vector<double> length;
  for (const JoinedPair& s : joined) {
    springs.pairs.push_back({s.a, s.b});
    stiffness.push_back(s.k);
    length.push_back(s.l);
  }
  springs.stiffness = std::move(stiffness);
  springs.rest_length = Scalars(std::move(length));
  springs.damping = grid.damping;
  return springs;
}

std::vector<JoinedPair> joined_pairs(const Scene& scene, std::span<const Vec3> start) {
  std::vector<JoinedPair> pairs;
  for (const Network& network : scene.networks) {
    if (const auto* grid = std::get_if<Grid>(&network)) {
      append(*grid, pairs);
    } else {
      append(std::get<Springs>(network), start, pairs);
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const JoinedPair& s, const JoinedPair& t) { return std::pair(s.a, s.b) < std::pair(t.a, t.b); });
  return pairs;
}

const Grid* only_grid(const Scene& scene, std::size_t count) {
  if (scene.networks.size() != 1) return nullptr;
  const auto* grid = std::get_if<Grid>(&scene.networks[0]);
  return grid != nullptr && grid->first == 0 && grid->rows * grid->columns == count ? grid : nullptr;
}

Places places_in_grid(const Grid& grid, std::size_t phases) {
  Places places;
  places.phases = phases;
  const std::size_t longest = (grid.columns + phases - 1) / phases;
  // Sweeps store whole registers, which may start at a line's second element.
  places.pitch = filled(longest) + (phases == 1 ? 0 : slice);
  places.size = grid.rows * phases * places.pitch;
  for (std::size_t row = 0; row < grid.rows; ++row) {
    for (std::size_t phase = 0; phase < std::min(phases, grid.columns); ++phase) {
      places.runs.push_back({.particle = row * grid.columns + phase,
                             .every = phases,
                             .element = (row * phases + phase) * places.pitch,
                             .count = (grid.columns - phase + phases - 1) / phases});
    }
  }
  fill_places(places, grid.rows * grid.columns);
  return places;
}

Places places_in_graph(std::span<const JoinedPair> springs, std::size_t count) {
  Places places;
  places.size = filled(count);
  std::vector<std::uint32_t> own(count);
  std::iota(own.begin(), own.end(), 0U);
  const std::vector<std::uint32_t> near = near_order(springs, count);
  std::vector<std::uint32_t> element_of(count);
  for (std::size_t k = 0; k < count; ++k) element_of[near[k]] = static_cast<std::uint32_t>(k);
  // An order that the caller's arrays do not have costs an indexed copy of every column.
  const bool is_worth_it = spread(springs, element_of) < spread(springs, own) / 4;
  if (!is_worth_it) {
    for (std::size_t first = 0; first < count; first += run_length) {
      const std::size_t now = std::min(run_length, count - first);
      places.runs.push_back({.particle = first, .every = 1, .element = first, .count = now});
    }
  } else {
    for (std::size_t k = 0; k < count; ++k) places.runs.push_back({.particle = near[k], .every = 1, .element = k, .count = 1});
  }
  fill_places(places, count);
  return places;
}

}  // namespace dvdx
