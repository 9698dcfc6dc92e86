// Springs of meshes of triangles.
#include "dvdx/cloth.hpp"

#include <array>
#include <utility>

#include "topology/joined_lengths.hpp"

namespace dvdx {
namespace {

void keep_each_once(std::vector<Pair>& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

}  // namespace

std::vector<Pair> edges(std::span<const Triangle> triangles) {
  std::vector<Pair> pairs;
  for (const auto& [a, b, c] : triangles) pairs.insert(pairs.end(), {ascending({a, b}), ascending({b, c}), ascending({a, c})});
  keep_each_once(pairs);
  return pairs;
}

std::vector<Pair> bend_pairs(std::span<const Triangle> triangles) {
  std::vector<std::pair<Pair, std::uint32_t>> sides;  // and the corner across each
  for (const auto& [a, b, c] : triangles) {
    sides.insert(sides.end(), {{ascending({a, b}), c}, {ascending({b, c}), a}, {ascending({a, c}), b}});
  }
  std::sort(sides.begin(), sides.end());
  std::vector<Pair> pairs;
  for (std::size_t first = 0; first < sides.size();) {
    std::size_t end = first + 1;
    while (end < sides.size() && sides[end].first == sides[first].first) ++end;
    if (end == first + 2 && sides[first].second != sides[first + 1].second) {
      pairs.push_back(ascending({sides[first].second, sides[first + 1].second}));
    }
    first = end;
  }
  keep_each_once(pairs);
  return pairs;
}

Springs springs_of(std::span<const Triangle> triangles, const Cloth& cloth) {
  Springs springs{.pairs = edges(triangles), .stiffness = cloth.stretch, .damping = cloth.damping};
  springs.triangles.assign(triangles.begin(), triangles.end());
  springs.aerodynamics = cloth.air;
  if (cloth.bend == 0) return springs;
  const std::size_t along = springs.pairs.size();
  for (const Pair& pair : bend_pairs(triangles)) {
    if (!std::binary_search(springs.pairs.begin(), springs.pairs.begin() + static_cast<std::ptrdiff_t>(along), pair)) {
      springs.pairs.push_back(pair);
    }
  }
  std::vector<double> stiffness(springs.pairs.size(), cloth.bend);
  std::fill_n(stiffness.begin(), along, cloth.stretch);
  springs.stiffness = std::move(stiffness);
  return springs;
}

}  // namespace dvdx
