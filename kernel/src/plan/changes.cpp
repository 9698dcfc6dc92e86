// Pins, releases, tears, masses, stiffness: refusals, and the edit of the scene. The compiled scene follows in in_place.cpp.
#include "plan/changes.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "dvdx/bending.hpp"
#include "scene/checker.hpp"
#include "scene/particle_values.hpp"
#include "topology/particle_order.hpp"

namespace dvdx {
namespace {

template <class Kind>
std::optional<Error> refusal_of(const Scene& scene, std::size_t network) {
  constexpr bool is_grid = std::is_same_v<Kind, Grid>;
  if (network >= scene.networks.size()) return no_such("networks", network, scene.networks.size());
  if (std::holds_alternative<Kind>(scene.networks[network])) return std::nullopt;
  return Error{element("networks", network), is_grid ? "a list of springs" : "a grid",
               is_grid ? "a grid" : "a list of springs"};
}

std::optional<Error> refusal_of_particle(std::size_t particle, std::optional<std::size_t> count) {
  if (!count || particle < *count) return std::nullopt;
  return Error{"particle", std::to_string(particle), "a particle id below " + std::to_string(*count)};
}

bool is_same(const Pair& a, const Pair& b) { return a == b || a == Pair{b[1], b[0]}; }

bool holds(std::span<const Pair> pairs, const Pair& ends) {
  return std::any_of(pairs.begin(), pairs.end(), [&](const Pair& pair) { return is_same(pair, ends); });
}

}  // namespace

std::optional<Error> GridStiffnessChange::refusal(const Scene& scene, std::optional<std::size_t> /*count*/) const {
  return refusal_of<Grid>(scene, network);
}
void GridStiffnessChange::apply(Scene& scene, std::size_t /*count*/) const {
  Grid& grid = std::get<Grid>(scene.networks[network]);
  grid.structural = stiffness.structural;
  grid.shear = stiffness.shear;
  grid.bend = stiffness.bend;
  grid.damping = stiffness.damping;
}

std::optional<Error> SpringsStiffnessChange::refusal(const Scene& scene, std::optional<std::size_t> /*count*/) const {
  return refusal_of<Springs>(scene, network);
}
void SpringsStiffnessChange::apply(Scene& scene, std::size_t /*count*/) const {
  Springs& springs = std::get<Springs>(scene.networks[network]);
  springs.stiffness = stiffness.stiffness;
  springs.damping = stiffness.damping;
}

namespace {

// The part of a network that set_network() does not change.
Grid layout_of(Grid grid) {
  grid.structural = grid.shear = grid.bend = grid.damping = 0;
  grid.broken.clear();
  grid.aerodynamics.reset();
  return grid;
}
Springs layout_of(Springs springs) {
  springs.stiffness = springs.zero_length = 0.0;
  springs.damping = 0;
  springs.broken.clear();
  springs.aerodynamics.reset();
  return springs;
}

}  // namespace

std::optional<Error> refusal_of(const Scene& scene, std::size_t index, const Network& network) {
  if (index >= scene.networks.size()) return no_such("networks", index, scene.networks.size());
  const auto layout = [](const Network& of) { return std::visit([](const auto& n) -> Network { return layout_of(n); }, of); };
  if (layout(scene.networks[index]) == layout(network)) return std::nullopt;
  return Error{element("networks", index), "another kind, or of other particles or lengths",
               "one that joins the same particles by springs of the same rest lengths"};
}
Network with_broken_of(const Network& before, Network network) {
  const auto take = [&](auto& to) { to.broken = std::get<std::decay_t<decltype(to)>>(before).broken; };
  std::visit(take, network);
  return network;
}

std::optional<Error> ZeroLengthChange::refusal(const Scene& scene, std::optional<std::size_t> /*count*/) const {
  return refusal_of<Springs>(scene, network);
}
void ZeroLengthChange::apply(Scene& scene, std::size_t /*count*/) const {
  std::get<Springs>(scene.networks[network]).zero_length = zero_length;
}
Expected<Scalars> zero_length_of(const Scene& scene, std::size_t network, std::span<const Triangle> triangles,
                                 std::span<const Vec3> flat, double modulus) {
  if (auto error = refusal_of<Springs>(scene, network)) return tl::unexpected(*error);
  if (!Range::non_negative.holds(modulus)) {
    return tl::unexpected(Error{"modulus", text(modulus), std::string(Range::non_negative.text)});
  }
  Springs springs{.pairs = std::get<Springs>(scene.networks[network]).pairs};
  const std::size_t count = springs.pairs.size();
  add_bending(springs, triangles, flat, modulus);
  if (springs.pairs.size() == count) return std::move(springs.zero_length);
  return tl::unexpected(Error{element("networks", network) + ".pairs", "without " + text(springs.pairs[count]),
                              "all pairs that add_bending() adds for these triangles"});
}

std::optional<Error> MassChange::refusal(const Scene& scene, std::optional<std::size_t> count) const {
  if (!count && scene.mass.is_uniform()) {
    return Error{"mass", "one for all particles of a plan that does not know how many there are", "one for each"};
  }
  if (!(mass > 0) || !std::isfinite(mass)) return Error{element("mass", particle), text(mass), "a finite number > 0"};
  return refusal_of_particle(particle, count);
}
void MassChange::apply(Scene& scene, std::size_t count) const {
  scene.mass.make_each(count);
  scene.mass.set(particle, mass);
}

std::optional<Error> PinChange::refusal(const Scene& scene, std::optional<std::size_t> count) const {
  if (is_fixed(scene, particle) || is_kinematic(scene, particle)) {
    return Error{"particle", std::to_string(particle), "one that is neither fixed nor kinematic"};
  }
  return refusal_of_particle(particle, count);
}
void PinChange::apply(Scene& scene, std::size_t /*count*/) const {
  scene.fixed.insert(std::lower_bound(scene.fixed.begin(), scene.fixed.end(), particle), particle);
}

std::optional<Error> ReleaseChange::refusal(const Scene& scene, std::optional<std::size_t> count) const {
  if (auto error = refusal_of_particle(particle, count)) return error;
  if (!is_fixed(scene, particle)) return Error{"particle", std::to_string(particle), "one that is fixed"};
  return std::nullopt;
}
void ReleaseChange::apply(Scene& scene, std::size_t /*count*/) const {
  scene.fixed.erase(std::lower_bound(scene.fixed.begin(), scene.fixed.end(), particle));
}

std::optional<Error> TearChange::refusal(const Scene& scene, std::optional<std::size_t> /*count*/) const {
  if (network >= scene.networks.size()) return no_such("networks", network, scene.networks.size());
  const auto* grid = std::get_if<Grid>(&scene.networks[network]);
  const auto* springs = std::get_if<Springs>(&scene.networks[network]);
  for (std::size_t k = 0; k < ends.size(); ++k) {
    const bool is_joined = grid != nullptr ? spring_between(*grid, ends[k]).has_value() : holds(springs->pairs, ends[k]);
    const bool is_whole = !holds(grid != nullptr ? grid->broken : springs->broken, ends[k]) && !holds(ends.first(k), ends[k]);
    if (is_joined && is_whole) continue;
    return Error{element("networks", network) + ".broken", text(ends[k]),
                 "two particles that a whole spring of the network joins"};
  }
  return std::nullopt;
}
void TearChange::apply(Scene& scene, std::size_t /*count*/) const {
  std::visit([&](auto& network_) { network_.broken.insert(network_.broken.end(), ends.begin(), ends.end()); },
             scene.networks[network]);
}

}  // namespace dvdx
