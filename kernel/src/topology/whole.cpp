#include "topology/whole.hpp"

#include <algorithm>

#include "topology/piece_colours.hpp"

namespace dvdx {
namespace {

// Returns 0 for a fixed particle, otherwise 1, whatever its mass.
std::vector<double> held_or_not(const Scene& scene, std::size_t count) {
  std::vector<double> w(count, 1);
  for (const std::size_t i : scene.fixed) w[i] = 0;
  for (const Kinematic& followers : scene.kinematic) {
    for (const std::size_t i : followers.particles) w[i] = 0;
  }
  return w;
}

}  // namespace

Grid rows_of(const ListSheet& sheet) {
  return Grid{.rows = sheet.rows, .columns = sheet.columns, .bend = sheet.reach == 2 ? 1.0 : 0.0};
}

JoinedScene joined_anywhere(const Scene& scene, std::size_t count) {
  const std::vector<Vec3> nowhere(count);
  return {scene, nowhere};
}

Whole::Whole(const Scene& of, std::size_t count) : scene(of), joined(joined_anywhere(scene, count)) {
  const Walk walk = topology().walk();
  if (walk == Walk::grid) rows = *joined.stepped.own();
  if (walk == Walk::stack && is_swept(scene)) stacked = count / scene.networks.size();
  if (const auto& list = topology().list_sheet()) {
    rows = rows_of(*list);
    at_.resize(list->place.size());
    for (std::size_t i = 0; i < at_.size(); ++i) at_[list->place[i]] = static_cast<std::uint32_t>(i);
  }
  has_pieces = walk == Walk::pieces && !scene.networks.empty();
  if (!has_pieces) return;
  colour_of = colours_between_pieces(joined.pairs, topology().order(), held_or_not(scene, count));
  for (const std::uint32_t colour : colour_of) colours = std::max(colours, colour);
}

}  // namespace dvdx
