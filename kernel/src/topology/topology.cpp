#include "topology/topology.hpp"

#include <utility>

namespace dvdx {
namespace {

Walk walk_of(const SteppedGrid& stepped) noexcept { return stepped.is_stack() ? Walk::stack : Walk::grid; }

}  // namespace

Walk swept_walk(const Scene& scene, std::span<const JoinedPair> pairs, std::size_t count) {
  const SteppedGrid stepped(scene, count);
  if (stepped.get() != nullptr) return walk_of(stepped);
  return list_sheet(scene, pairs, count) ? Walk::sheet : Walk::pieces;
}

SpringsAre springs_are(std::span<const JoinedPair> pairs, std::size_t count, Walk swept) {
  return swept != Walk::pieces || are_ropes(pairs, count) ? SpringsAre::in_rows : SpringsAre::any;
}

Topology::Topology(const Scene& scene, const SteppedGrid& stepped, std::size_t count, std::span<const JoinedPair> pairs,
                   std::span<const JoinedPair> constrained, const PartContext& elsewhere)
    : is_one_grid_(only_grid(scene, count) != nullptr), neighbours_(grid_neighbours(scene)) {
  const bool is_swept = scene.coupling.scheme == Scheme::sequential;
  if (const Grid* const grid = stepped.get()) {
    walk_ = walk_of(stepped);
    order_ = rows_order(grid->rows, grid->columns, !is_swept ? 1 : (grid->bend != 0 ? 4 : 2));
    return;
  }
  const SweptPart* const given = is_swept ? elsewhere.sweeps : nullptr;
  if (given != nullptr && given->columns != 0) {
    list_sheet_ = given_sheet(*given, count);
  } else if (given == nullptr && is_swept) {
    list_sheet_ = dvdx::list_sheet(scene, pairs, count);
  }
  walk_ = list_sheet_ ? Walk::sheet : (is_swept ? Walk::pieces : Walk::graph);
  if (list_sheet_) {
    order_ = rows_order(list_sheet_->rows, list_sheet_->columns, list_sheet_->phases(), list_sheet_->place);
  } else if (given != nullptr) {
    order_ = part_order(given->piece_ends, count);
  } else if (elsewhere.exchange.start != nullptr) {
    order_ = own_order(count);
  } else {
    std::vector<JoinedPair> near(pairs.begin(), pairs.end());
    near.insert(near.end(), constrained.begin(), constrained.end());
    order_ = is_swept ? pieces_order(near, count) : graph_order(near, count);
  }
}

std::size_t Topology::place_of(std::size_t particle) const noexcept {
  if (walk_ == Walk::grid || walk_ == Walk::stack) return particle;
  return list_sheet_ ? list_sheet_->place_of(particle) : order_.of[particle];
}

bool Topology::is_kept_by(const Scene& changed, const SteppedGrid& stepped) const {
  return stepped.get() == nullptr && walk_ != Walk::stack && neighbours_ == grid_neighbours(changed);
}

JoinedScene::JoinedScene(const Scene& scene, std::span<const Vec3> start, std::span<const JoinedPair> constrained,
                         const PartContext& elsewhere, std::shared_ptr<const Topology> kept)
    : stepped(scene, start.size(), elsewhere), topology(std::move(kept)) {
  if (stepped.get() == nullptr) pairs = joined_pairs(scene, start);
  if (topology != nullptr && topology->is_kept_by(scene, stepped)) return;
  topology = std::make_shared<const Topology>(scene, stepped, start.size(), pairs, constrained, elsewhere);
}

}  // namespace dvdx
