// The scene that a part steps: the particles that it holds of the whole, by numbers of its own.
#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <variant>

#include "dvdx/partition.hpp"
#include "scene/particle_values.hpp"
#include "topology/particle_order.hpp"
#include "topology/renumbered.hpp"
#include "topology/whole.hpp"

namespace dvdx {
namespace {

Scalars taken(const Scalars& values, std::span<const std::uint32_t> particles) {
  if (values.is_uniform()) return values;
  std::vector<double> each;
  each.reserve(particles.size());
  for (const std::uint32_t i : particles) each.push_back(values[i]);
  return each;
}
PerAxis taken(const PerAxis& values, std::span<const std::uint32_t> particles) {
  return values.is_uniform() ? values : PerAxis(taken(values.scalars(), particles));
}
Anchor taken(const Anchor& anchor, std::span<const std::uint32_t> particles) {
  const auto* all = std::get_if<std::vector<Vec3>>(&anchor);
  if (all == nullptr) return anchor;
  std::vector<Vec3> each;
  each.reserve(particles.size());
  for (const std::uint32_t i : particles) each.push_back((*all)[i]);
  return each;
}

// Returns the triangles between the part's particles. In air these are the triangles of its own particles, and those that share
// a particle with them.
std::vector<Triangle> taken(const std::vector<Triangle>& whole, const Renumbered& renumbered) {
  std::vector<Triangle> triangles;
  for (const auto& [a, b, c] : whole) {
    const auto i = renumbered(a);
    const auto j = renumbered(b);
    const auto k = renumbered(c);
    if (i && j && k) triangles.push_back({*i, *j, *k});
  }
  return triangles;
}

// The springs that a part takes: those that reach a particle of its own, or, for a list in swept rows, all between its rows.
enum class Taken : std::uint8_t { own, all };

Springs taken(const Springs& whole, const Renumbered& renumbered, Taken which) {
  Springs springs{.pairs = {}, .damping = whole.damping};
  springs.triangles = taken(whole.triangles, renumbered);
  if (!springs.triangles.empty()) springs.aerodynamics = whole.aerodynamics;
  std::vector<std::uint32_t> kept;
  const auto both = [&](const Pair& pair) -> std::optional<Pair> {
    const auto a = renumbered(pair[0]);
    const auto b = renumbered(pair[1]);
    if (!a || !b) return std::nullopt;
    if (which == Taken::own && !renumbered.is_own(*a) && !renumbered.is_own(*b)) return std::nullopt;
    return Pair{*a, *b};
  };
  for (std::size_t s = 0; s < whole.pairs.size(); ++s) {
    const auto pair = both(whole.pairs[s]);
    if (!pair) continue;
    springs.pairs.push_back(*pair);
    kept.push_back(static_cast<std::uint32_t>(s));
  }
  springs.stiffness = taken(whole.stiffness, kept);
  if (whole.rest_length) springs.rest_length = taken(*whole.rest_length, kept);
  springs.zero_length = taken(whole.zero_length, kept);
  for (const Pair& torn : whole.broken) {
    if (const auto pair = both(torn)) springs.broken.push_back(*pair);
  }
  return springs;
}

// Returns the part's rows, if it holds whole consecutive ones.
std::optional<Grid> rows_of(const Grid& whole, const Part& part) {
  const auto& numbers = part.particles;
  if (numbers.empty() || numbers.front() % whole.columns != 0 || numbers.size() % whole.columns != 0) return std::nullopt;
  if (numbers.back() >= whole.rows * whole.columns) return std::nullopt;  // behind its last row
  if (numbers.back() - numbers.front() + 1 != numbers.size() || numbers.size() < 2 * whole.columns) return std::nullopt;
  Grid grid = whole;
  grid.rows = numbers.size() / whole.columns;
  grid.rows_of_whole = whole.rows_of_whole != 0 ? whole.rows_of_whole : whole.rows;
  grid.broken.clear();
  for (const auto& [a, b] : whole.broken) {
    if (std::min(a, b) < numbers.front() || std::max(a, b) > numbers.back()) continue;
    grid.broken.push_back({a - numbers.front(), b - numbers.front()});
  }
  return grid;
}

// Returns those of several sheets that the part has.
std::vector<Network> sheets_of(const Scene& whole, const Renumbered& renumbered) {
  std::vector<Network> sheets;
  for (const Network& network : whole.networks) {
    Grid grid = std::get<Grid>(network);
    const auto first = renumbered(grid.first);
    if (!first) continue;
    for (Pair& torn : grid.broken) torn = {*renumbered(torn[0]), *renumbered(torn[1])};
    grid.first = *first;
    sheets.emplace_back(std::move(grid));
  }
  return sheets;
}

// Returns the skin of those of its particles that the part holds, with the values of each.
Skin taken(const Skin& whole, const Renumbered& renumbered) {
  Skin skin{.particles = {}, .backstop = whole.backstop, .motion = whole.motion};
  std::vector<std::uint32_t> kept;
  for (std::size_t k = 0; k < whole.particles.size(); ++k) {
    const auto number = renumbered(whole.particles[k]);
    if (!number) continue;
    skin.particles.push_back(*number);
    kept.push_back(static_cast<std::uint32_t>(k));
  }
  if (kept.empty()) {
    if (skin.backstop) skin.backstop = Backstop{.normals = {whole.backstop->normals.at(0)}};
    return skin;
  }
  const auto some = [&](const std::vector<Vec3>& all) {
    std::vector<Vec3> each;
    each.reserve(kept.size());
    for (const std::uint32_t k : kept) each.push_back(all[k]);
    return each;
  };
  if (!whole.points.empty()) skin.points = some(whole.points);
  skin.at_most = taken(whole.at_most, kept);
  if (skin.backstop) {
    if (whole.backstop->normals.size() > 1) skin.backstop->normals = some(whole.backstop->normals);
    skin.backstop->offset = taken(whole.backstop->offset, kept);
    skin.backstop->radius = taken(whole.backstop->radius, kept);
  }
  return skin;
}

}  // namespace

Scene scene_of(const Scene& whole, const Part& part) {
  Scene scene = whole;
  const Renumbered renumbered(part);
  for_each_particle_value_of(scene, [&](const std::string&, auto& value) { value = taken(value, part.particles); });
  const auto renumber = [&](std::vector<std::size_t>& list) {
    std::vector<std::size_t> kept;
    for (const std::size_t i : list) {
      if (const auto number = renumbered(i)) kept.push_back(*number);
    }
    list = std::move(kept);
  };
  renumber(scene.fixed);
  std::sort(scene.fixed.begin(), scene.fixed.end());
  for (Kinematic& followers : scene.kinematic) renumber(followers.particles);
  for (Skin& skin : scene.skins) skin = taken(skin, renumbered);
  if (is_swept(whole) && !part.sweeps && whole.networks.size() > 1) {
    scene.networks = sheets_of(whole, renumbered);
    return scene;
  }
  const Taken which = part.sweeps && part.sweeps->columns != 0 ? Taken::all : Taken::own;
  for (Network& network : scene.networks) {
    if (const auto* grid = std::get_if<Grid>(&network)) {
      const bool is_alone = whole.networks.size() == 1 && whole.coupling.scheme != Scheme::accumulate && grid->first == 0;
      if (const auto rows = is_alone ? rows_of(*grid, part) : std::nullopt) {
        network = *rows;
      } else {
        network = taken(springs_of(*grid), renumbered, which);
      }
    } else {
      network = taken(std::get<Springs>(network), renumbered, which);
    }
  }
  return scene;
}

}  // namespace dvdx
