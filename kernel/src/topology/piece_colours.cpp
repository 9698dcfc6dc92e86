#include "topology/piece_colours.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "topology/colouring.hpp"

namespace dvdx {

// Colours greedily, in the order of the ends' elements.
std::vector<std::uint32_t> colours_between_pieces(std::span<const JoinedPair> springs, const ParticleOrder& order,
                                                  std::span<const double> w) {
  std::vector<std::size_t> between;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const auto [a, b] = std::pair(springs[s].a, springs[s].b);
    if ((w[a] != 0 || w[b] != 0) && order.piece_of(a) != order.piece_of(b)) between.push_back(s);
  }
  const auto ends = [&](std::size_t s) { return std::minmax({order.of[springs[s].a], order.of[springs[s].b]}); };
  std::stable_sort(between.begin(), between.end(), [&](std::size_t s, std::size_t t) { return ends(s) < ends(t); });
  std::vector<std::uint32_t> colour_of(springs.size(), 0);
  Colouring colouring(w.size());
  for (const std::size_t s : between) {
    colour_of[s] = static_cast<std::uint32_t>(colouring.add(std::array{springs[s].a, springs[s].b})) + 1;
  }
  return colour_of;
}

}  // namespace dvdx
