#include "topology/triangles.hpp"

#include <algorithm>

#include "topology/particle_order.hpp"

namespace dvdx {
namespace {

Pair ascending(std::uint32_t i, std::uint32_t j) { return {std::min(i, j), std::max(i, j)}; }

// Each in ascending order.
std::vector<Pair> torn_sides(const std::vector<Pair>& broken) {
  std::vector<Pair> sides = broken;
  for (Pair& ends : sides) ends = ascending(ends[0], ends[1]);
  std::sort(sides.begin(), sides.end());
  return sides;
}

bool is_torn(const Triangle& t, const std::vector<Pair>& sides) {
  const auto is_side = [&](std::uint32_t i, std::uint32_t j) {
    return std::binary_search(sides.begin(), sides.end(), ascending(i, j));
  };
  return !sides.empty() && (is_side(t[0], t[1]) || is_side(t[1], t[2]) || is_side(t[2], t[0]));
}

std::vector<Triangle> triangles_of(const Springs& springs) { return springs.triangles; }

}  // namespace

std::vector<Triangle> whole_triangles(const Network& network) {
  const std::vector<Pair> torn = std::visit([](const auto& of) { return torn_sides(of.broken); }, network);
  std::vector<Triangle> found;
  for (const Triangle& t : std::visit([](const auto& of) { return triangles_of(of); }, network)) {
    if (!is_torn(t, torn)) found.push_back(t);
  }
  return found;
}

}  // namespace dvdx
