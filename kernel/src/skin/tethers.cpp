// Finds the particle that each tether hangs from. How tethers hold: ball.hpp.
#include "skin/tethers.hpp"

#include <functional>
#include <queue>
#include <tuple>

namespace dvdx {

// Dijkstra's algorithm from all anchors at once. Among anchors that are equally far the one with the least number counts.
std::vector<TetherTo> tethers_of(std::span<const JoinedPair> springs, std::span<const double> w) {
  struct Edge {
    std::uint32_t to;
    double length;
  };
  std::vector<std::vector<Edge>> edges(w.size());
  for (const JoinedPair& spring : springs) {
    if (spring.is_broken) continue;
    edges[spring.a].push_back({spring.b, spring.l});
    edges[spring.b].push_back({spring.a, spring.l});
  }
  using Reached = std::tuple<double, std::uint32_t, std::uint32_t>;  // length, anchor, particle
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> next;
  for (std::uint32_t i = 0; i < w.size(); ++i) {
    if (w[i] == 0 && !edges[i].empty()) next.emplace(0.0, i, i);
  }
  std::vector<TetherTo> found(w.size());
  while (!next.empty()) {
    const auto [length, anchor, i] = next.top();
    next.pop();
    if (found[i].anchor) continue;
    found[i] = {anchor, length};
    for (const Edge& edge : edges[i]) {
      if (!found[edge.to].anchor) next.emplace(length + edge.length, anchor, edge.to);
    }
  }
  return found;
}

}  // namespace dvdx
