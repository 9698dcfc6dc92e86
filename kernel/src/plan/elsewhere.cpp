#include "dvdx/elsewhere.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "free/system.hpp"
#include "plan/compiled_scene.hpp"
#include "plan/validate.hpp"
#include "scene/checker.hpp"
#include "springs/sweep/sweep_scheme.hpp"
#include "topology/list_sheet.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {
namespace {

bool holds_any(const Skin& skin) {
  const auto is_held = [&](std::size_t k) { return skin.backstop || !std::isinf(skin.at_most[k]); };
  for (std::size_t k = 0; k < skin.particles.size(); ++k) {
    if (is_held(k)) return true;
  }
  return false;
}

PartContext rates_of(const Scene& scene, std::size_t count) {
  const System system(scene, {}, 1);
  PartContext found{.anchors_differ = system.anchors_differ()};
  found.closes_substeps = std::any_of(scene.skins.begin(), scene.skins.end(), holds_any);
  const std::size_t axes = system.is_isotropic() ? 1 : 3;
  for (std::size_t i = 0; i < (system.is_uniform() ? std::min<std::size_t>(count, 1) : count); ++i) {
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const Rate rate = system.total_rate(axis, i);
      found.W = std::max(found.W, rate.W);
      found.g = std::max(found.g, rate.g);
    }
  }
  return found;
}

bool is_linear_spring(const Force& force) {
  return std::holds_alternative<RadialSpring>(force) && std::holds_alternative<Spring>(with_linear_spring(force));
}

}  // namespace

namespace {

// Whether `ends` are the ascending ends of pieces of `count` particles at most.
bool are_pieces(std::span<const std::uint32_t> ends, std::size_t count) {
  std::uint32_t before = 0;
  for (const std::uint32_t end : ends) {
    if (end <= std::exchange(before, end) || end > count) return false;
  }
  return !ends.empty();
}

// The first spring with a wrong colour, if any. A spring between pieces that moves something must have one, and no two springs
// of one colour may share a particle.
std::optional<std::size_t> wrong_colour(std::span<const JoinedPair> pairs, const SweptPart& sweeps, const Scene& scene) {
  std::set<std::size_t> held(scene.fixed.begin(), scene.fixed.end());
  for (const Kinematic& followers : scene.kinematic) held.insert(followers.particles.begin(), followers.particles.end());
  const auto piece = [&](std::uint32_t i) {
    return std::upper_bound(sweeps.piece_ends.begin(), sweeps.piece_ends.end(), i) - sweeps.piece_ends.begin();
  };
  std::set<std::pair<std::uint32_t, std::uint32_t>> taken;  // colour, particle
  for (std::size_t s = 0; s < pairs.size(); ++s) {
    const auto [a, b] = std::pair(pairs[s].a, pairs[s].b);
    const std::uint32_t colour = sweeps.colour_of[s];
    const bool is_between = piece(a) != piece(b);
    if (colour == 0 && is_between && !(held.contains(a) && held.contains(b))) return s;
    if (colour == 0) continue;
    if (colour > sweeps.colours || !is_between) return s;
    if (!taken.emplace(colour, a).second || !taken.emplace(colour, b).second) return s;
  }
  return std::nullopt;
}

std::optional<Error> check_rows(const Scene& scene, const SweptPart& sweeps, std::size_t count) {
  if (!sweeps.piece_ends.empty() || !sweeps.colour_of.empty()) {
    return Error{"elsewhere.sweeps.columns", std::to_string(sweeps.columns), "0 where there are pieces"};
  }
  if (sweeps.reach != 1 && sweeps.reach != 2) {
    return Error{"elsewhere.sweeps.reach", std::to_string(sweeps.reach), "1 or 2"};
  }
  const std::vector<Vec3> nowhere(count);
  if (count % sweeps.columns == 0 && fits(joined_pairs(scene, nowhere), given_sheet(sweeps, count))) return std::nullopt;
  return Error{
      "elsewhere.sweeps.columns", std::to_string(sweeps.columns),
      "such that the particles stand in rows of so many and each spring, no two alike, leads to the next rows and columns" +
          std::string(sweeps.reach == 2 ? " or the second next" : "")};
}

// Whether every network is a list in which no particle has more than two springs. Only then can all together be ropes.
bool are_all_ropes(const Scene& scene) {
  return std::none_of(scene.networks.begin(), scene.networks.end(), [](const Network& network) {
    const auto* const springs = std::get_if<Springs>(&network);
    std::map<std::uint32_t, int> count;
    return springs == nullptr || std::any_of(springs->pairs.begin(), springs->pairs.end(),
                                             [&](const Pair& ends) { return ++count[ends[0]] > 2 || ++count[ends[1]] > 2; });
  });
}

SpringsAre springs_of_part(const Scene& scene, const SweptPart* sweeps, bool is_sheet) {
  return is_sheet || (sweeps != nullptr && sweeps->columns != 0) || are_all_ropes(scene) ? SpringsAre::in_rows
                                                                                         : SpringsAre::any;
}

}  // namespace

std::optional<Error> check_sweeps(const Scene& scene, const PartContext& elsewhere, std::optional<std::size_t> count) {
  const bool is_swept = scene.coupling.scheme == Scheme::sequential && !scene.networks.empty();
  const bool is_sheet = is_swept && count && SteppedGrid(scene, *count, elsewhere).get() != nullptr;
  const SweptPart* const sweeps = elsewhere.sweeps;
  if (is_swept && elsewhere.exchange.start != nullptr &&
      solves_lines(scene.coupling, springs_of_part(scene, sweeps, is_sheet))) {
    return Error{"coupling.lines", scene.coupling.lines == Lines::whole ? "whole" : "rows",
                 "none where a scene is stepped in parts: lines lead from part to part"};
  }
  if (!is_swept || !count || is_sheet) return std::nullopt;
  if (sweeps == nullptr) {
    if (elsewhere.exchange.start == nullptr) return std::nullopt;
    return Error{"elsewhere.sweeps", "null", "Part::sweeps of a part by sequential that is no sheet"};
  }
  if (sweeps->columns != 0) return check_rows(scene, *sweeps, *count);
  if (!are_pieces(sweeps->piece_ends, *count)) {
    return Error{"elsewhere.sweeps.piece_ends", std::to_string(sweeps->piece_ends.size()) + " numbers",
                 "at least one, ascending, up to the particles' " + std::to_string(*count)};
  }
  const std::vector<Vec3> nowhere(*count);
  const std::vector<JoinedPair> pairs = joined_pairs(scene, nowhere);
  const std::string colours = "elsewhere.sweeps.colour_of";
  if (sweeps->colour_of.size() != pairs.size()) {
    return Error{colours, std::to_string(sweeps->colour_of.size()) + " numbers",
                 "one for each of the " + std::to_string(pairs.size()) + " springs"};
  }
  const auto wrong = wrong_colour(pairs, *sweeps, scene);
  if (!wrong) return std::nullopt;
  return Error{element(colours, *wrong), std::to_string(sweeps->colour_of[*wrong]),
               "0 within a piece; else from 1 to " + std::to_string(sweeps->colours) + ", of no other spring of its particles"};
}

PartContext elsewhere_of(const Scene& scene, std::size_t count) {
  if (std::none_of(scene.forces.begin(), scene.forces.end(), is_linear_spring)) return rates_of(scene, count);
  Scene linear = scene;
  for (Force& force : linear.forces) force = with_linear_spring(force);
  return rates_of(linear, count);
}

}  // namespace dvdx
