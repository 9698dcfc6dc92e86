#include "watch/poke_watch.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

namespace dvdx::tool {
namespace {

// Whether particles are kept outside the body: a straight line between two that are outside may go through it.
bool can_poke(const Contact& contact) {
  if (std::holds_alternative<Plane>(contact)) return false;
  const auto is_outside = [](const auto& body) {
    if constexpr (requires { body.side; }) return body.side == Side::outside;
    return true;
  };
  return std::visit(is_outside, contact);
}

// Returns the bodies' surfaces alone, without thickness and push_out.
Scene bare_surfaces(const Scene& scene, std::span<const std::size_t> bodies) {
  Scene surfaces;
  surfaces.motions = scene.motions;
  surfaces.origin = scene.origin;
  for (const std::size_t j : bodies) {
    surfaces.contacts.push_back(scene.contacts[j]);
    const auto strip = [](auto& contact) {
      contact.push_out.reset();
      contact.thickness = 0;
    };
    std::visit(strip, surfaces.contacts.back());
  }
  return surfaces;
}

void add_cloth_sides(const Grid& grid, std::vector<Pair>& sides) {
  if (is_net(grid)) return;
  const auto at = [&](std::size_t r, std::size_t c) { return static_cast<std::uint32_t>(grid.first + r * grid.columns + c); };
  for (std::size_t r = 0; r < grid.rows; ++r) {
    for (std::size_t c = 0; c < grid.columns; ++c) {
      if (c + 1 < grid.columns) sides.push_back({at(r, c), at(r, c + 1)});
      if (r + 1 < grid.rows) sides.push_back({at(r, c), at(r + 1, c)});
      if (r + 1 < grid.rows && c + 1 < grid.columns) sides.push_back({at(r, c), at(r + 1, c + 1)});
    }
  }
}

void add_cloth_sides(const Springs& springs, std::vector<Pair>& sides) {
  for (const Triangle& triangle : springs.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = triangle[k];
      const auto b = triangle[(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b)});
    }
  }
}

double way_length(const Vec3& way) { return std::hypot(way[0], way[1], way[2]); }

}  // namespace

PokeWatch::PokeWatch(const SceneFile& file, int ranks) : file_(file) {
  const Scene& scene = file.scene;
  if (ranks > 1 || !file.tears_at.empty()) return;
  for (std::size_t j = 0; j < scene.contacts.size(); ++j) {
    if (can_poke(scene.contacts[j])) bodies_.push_back(j);
  }
}

void PokeWatch::begin(std::size_t count) {
  for (const Network& network : file_.scene.networks) {
    std::visit([&](const auto& of) { add_cloth_sides(of, sides_); }, network);
  }
  const std::vector<bool> are_free = free_ones(file_.scene, count);
  std::erase_if(sides_, [&](const Pair& side) { return !are_free[side[0]] || !are_free[side[1]]; });
  std::sort(sides_.begin(), sides_.end());
  sides_.erase(std::unique(sides_.begin(), sides_.end()), sides_.end());
  if (sides_.empty()) return bodies_.clear();
  middles_.emplace(sides_.size());
  state_ = middles_->view();
  ways_.emplace(bare_surfaces(file_.scene, bodies_), sides_.size());
}

PokeWatch::Deepest PokeWatch::deepest(PushOutProbe& ways) const {
  Deepest deepest;
  for (std::size_t first = 0; first < state_.count; first += PushOutProbe::at_once) {
    const auto out = ways.of(state_, first);
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (const double depth = way_length(out[i]); depth > deepest.depth) deepest = {first + i, depth};
    }
  }
  return deepest;
}

std::size_t PokeWatch::body_around(std::size_t middle) {
  if (each_.empty()) {
    for (const std::size_t& body : bodies_) each_.emplace_back(bare_surfaces(file_.scene, std::span(&body, 1)), 1);
  }
  std::size_t around = 0;
  double most = 0;
  for (std::size_t j = 0; j < bodies_.size(); ++j) {
    const double depth = way_length(each_[j].of(state_, middle).front());
    if (depth > most) around = j;
    most = std::max(most, depth);
  }
  return bodies_[around];
}

template <class T>
void PokeWatch::look(const State<T>& state) {
  if (!bodies_.empty() && !ways_) begin(state.count);
  if (bodies_.empty()) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t s = 0; s < sides_.size(); ++s) {
      const auto [i, j] = sides_[s];
      state_.x[axis][s] = 0.5 * (static_cast<double>(state.x[axis][i]) + static_cast<double>(state.x[axis][j]));
      state_.v[axis][s] = 0;
    }
  }
  state_.clock = state.clock;
  constexpr double seen = 10;  // least depths: a thousandth of the scene's extent, less is hardly seen
  const double limit = seen * least_depth(state);
  const Deepest now = deepest(*ways_);
  if (!(now.depth > limit) || (found_ && now.depth <= found_->depth)) return;
  const std::size_t contact = body_around(now.middle);
  const double thickness = std::visit([](const auto& of) { return of.thickness; }, file_.scene.contacts[contact]);
  constexpr double room = 1.2;  // a margin: cloth that is kept farther off lies differently
  found_ = {.between = sides_[now.middle],
            .contact = contact,
            .time = state.clock.seconds,
            .depth = now.depth,
            .limit = limit,
            .thickness = thickness + room * now.depth};
}

template void PokeWatch::look(const State<float>&);
template void PokeWatch::look(const State<double>&);

}  // namespace dvdx::tool
