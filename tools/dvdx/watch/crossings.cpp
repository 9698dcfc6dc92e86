#include "watch/crossings.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <variant>

#include "output/space.hpp"
#include "scene_io/scene_file.hpp"
#include "state/stored_springs.hpp"

namespace dvdx::tool {
namespace {

constexpr std::size_t most_in_leaf = 4;

bool goes_through(const Vec3& p, const Vec3& q, const std::array<Vec3, 3>& of) {
  const Vec3 normal = cross(difference(of[1], of[0]), difference(of[2], of[0]));
  const double start = dot(normal, difference(p, of[0]));
  const double end = dot(normal, difference(q, of[0]));
  if (!((start < 0 && end > 0) || (start > 0 && end < 0))) return false;
  const Vec3 along = difference(q, p);
  std::array<double, 3> sides{};
  for (std::size_t k = 0; k < 3; ++k) sides[k] = dot(along, cross(difference(of[k], p), difference(of[(k + 1) % 3], p)));
  const auto [least, most] = std::minmax_element(sides.begin(), sides.end());
  return *least >= 0 || *most <= 0;
}

void add_triangles(const Grid& grid, std::vector<Triangle>& to) {
  if (is_net(grid)) return;
  const auto at = [&](std::size_t r, std::size_t c) { return static_cast<std::uint32_t>(grid.first + r * grid.columns + c); };
  for (std::size_t r = 0; r + 1 < grid.rows; ++r) {
    for (std::size_t c = 0; c + 1 < grid.columns; ++c) {
      to.push_back({at(r, c), at(r, c + 1), at(r + 1, c + 1)});
      to.push_back({at(r, c), at(r + 1, c + 1), at(r + 1, c)});
    }
  }
}
void add_triangles(const Springs& springs, std::vector<Triangle>& to) {
  to.insert(to.end(), springs.triangles.begin(), springs.triangles.end());
}

}  // namespace

std::vector<Triangle> cloth_triangles(const Scene& scene) {
  std::vector<Triangle> triangles;
  for (const Network& network : scene.networks) {
    std::visit([&](const auto& of) { add_triangles(of, triangles); }, network);
  }
  return triangles;
}

std::vector<Pair> sewn_pairs(const Scene& scene) {
  std::vector<Pair> sewn;
  for (const Network& network : scene.networks) {
    const auto* const springs = std::get_if<Springs>(&network);
    if (springs == nullptr || !springs->rest_length) continue;
    for (std::size_t k = 0; k < springs->pairs.size(); ++k) {
      if ((*springs->rest_length)[k] == 0) sewn.push_back(springs->pairs[k]);
    }
  }
  return sewn;
}

void Crossings::Box::add(const Box& other) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    least[axis] = std::min(least[axis], other.least[axis]);
    most[axis] = std::max(most[axis], other.most[axis]);
  }
}
bool Crossings::Box::meets(const Box& other) const noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(least[axis] <= other.most[axis] && most[axis] >= other.least[axis])) return false;
  }
  return true;
}

Crossings::Crossings(std::vector<Triangle> triangles, std::span<const Pair> sewn)
    : triangles_(std::move(triangles)), edges_(edges(triangles_)) {
  if (sewn.empty()) return;
  std::uint32_t last = 0;
  for (const Triangle& of : triangles_) last = std::max(last, *std::max_element(of.begin(), of.end()));
  for (const Pair& pair : sewn) last = std::max(last, *std::max_element(pair.begin(), pair.end()));
  corner_.resize(last + std::size_t{1});
  std::iota(corner_.begin(), corner_.end(), 0U);
  const auto lowest = [&](std::uint32_t i) {
    while (corner_[i] != i) i = corner_[i] = corner_[corner_[i]];
    return i;
  };
  for (const auto& [a, b] : sewn) {
    const auto [low, high] = std::minmax(lowest(a), lowest(b));
    corner_[high] = low;
  }
  for (std::uint32_t i = 0; i <= last; ++i) corner_[i] = lowest(i);
}

template <class T>
std::size_t Crossings::count(const State<T>& state) {
  x_.resize(state.count);
  for (std::size_t i = 0; i < state.count; ++i) x_[i] = vector_at(state.x, i);
  return count();
}

std::size_t Crossings::count() {
  build();
  std::size_t found = 0;
  for (const Pair& edge : edges_) found += through(edge);
  return found;
}

Crossings::Box Crossings::box_of(std::span<const std::uint32_t> corners) const noexcept {
  Box box{x_[corners[0]], x_[corners[0]]};
  for (const std::uint32_t i : corners.subspan(1)) box.add({x_[i], x_[i]});
  return box;
}

double Crossings::side_of(const std::array<Vec3, 3>& corners) noexcept {
  std::array<double, 3> sides{};
  for (std::size_t k = 0; k < 3; ++k) sides[k] = length_between(corners[k], corners[(k + 1) % 3]);
  std::sort(sides.begin(), sides.end());
  return sides[1];
}

void Crossings::build() {
  boxes_.resize(triangles_.size());
  order_.clear();
  longest_side_ = 0;
  const auto is_there = [&](std::uint32_t i) { return is_finite(x_[i]); };
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    if (!std::all_of(triangles_[t].begin(), triangles_[t].end(), is_there)) continue;
    boxes_[t] = box_of(triangles_[t]);
    order_.push_back(t);
    const Triangle& of = triangles_[t];
    const double side = side_of({x_[of[0]], x_[of[1]], x_[of[2]]});
    longest_side_ = std::max(longest_side_, units_.empty() ? side : side / units_[t]);
  }
  nodes_.clear();
  if (!order_.empty()) build(0, order_.size());
}

// Splits the triangles in halves along the longest side of their box.
std::size_t Crossings::build(std::size_t from, std::size_t to) {
  const std::size_t node = nodes_.size();
  nodes_.push_back({.box = boxes_[order_[from]], .from = from, .to = to});
  for (std::size_t k = from + 1; k < to; ++k) nodes_[node].box.add(boxes_[order_[k]]);
  if (to - from <= most_in_leaf) return node;
  const Vec3 size = difference(nodes_[node].box.most, nodes_[node].box.least);
  const auto axis = static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin());
  const std::size_t half = from + (to - from) / 2;
  const auto at = [&](std::size_t k) { return order_.begin() + static_cast<std::ptrdiff_t>(k); };
  const auto middle = [&](std::uint32_t t) { return boxes_[t].least[axis] + boxes_[t].most[axis]; };
  std::nth_element(at(from), at(half), at(to), [&](std::uint32_t s, std::uint32_t t) { return middle(s) < middle(t); });
  build(from, half);
  const std::size_t second = build(half, to);
  nodes_[node].second = second;
  return node;
}

std::size_t Crossings::through(const Pair& edge) {
  const Box box = box_of(edge);
  const auto counts = [&](std::uint32_t t) {
    const Triangle& of = triangles_[t];
    const bool is_corner = std::any_of(of.begin(), of.end(), [&](std::uint32_t i) {
      return corner_of(i) == corner_of(edge[0]) || corner_of(i) == corner_of(edge[1]);
    });
    return !is_corner && boxes_[t].meets(box) && goes_through(x_[edge[0]], x_[edge[1]], {x_[of[0]], x_[of[1]], x_[of[2]]});
  };
  std::size_t found = 0;
  open_.assign(nodes_.empty() ? 0 : 1, 0);
  while (!open_.empty()) {
    const std::size_t number = open_.back();
    open_.pop_back();
    const Node& node = nodes_[number];
    if (!node.box.meets(box)) continue;
    if (node.second != 0) {
      open_.push_back(number + 1);
      open_.push_back(node.second);
      continue;
    }
    for (std::size_t k = node.from; k < node.to; ++k) found += counts(order_[k]) ? 1U : 0U;
  }
  return found;
}

template std::size_t Crossings::count(const State<float>&);
template std::size_t Crossings::count(const State<double>&);

}  // namespace dvdx::tool
