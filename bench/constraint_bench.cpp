// The constraint pass: pairs that share no particle, and ropes.
#include <cstdint>
#include <optional>
#include <utility>

#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"

namespace dvdx::bench {
namespace {

// Rods or ropes of `links` one after the other, as long as they are at the start. The reference that results are compared with
// holds 4097 particles: the last of them is alone in every batch.
Scene linked(std::size_t count, std::uint32_t links, Bound bound) {
  Scene scene = fall();
  Distance distance{.pairs = {}, .length = std::nullopt, .bound = bound};
  for (std::uint32_t i = 1; i < count; ++i) {
    if (i % (links + 1) != 0 && i / (links + 1) != 4096 / (links + 1)) distance.pairs.push_back({i - 1, i});
  }
  return scene.add(std::move(distance));
}

template <class T>
void add_linked() {
  add_in_cache<T>({.name = "constraint/rods", .scene = [](std::size_t n) { return linked(n, 1, Bound::equal); }});
  add_in_cache<T>({.name = "constraint/ropes_of_15", .scene = [](std::size_t n) { return linked(n, 15, Bound::equal); }});
  add_in_cache<T>({.name = "constraint/strain_limits", .scene = [](std::size_t n) { return linked(n, 15, Bound::at_most); }});
}

}  // namespace

void register_constraint() {
  add_linked<float>();
  add_linked<double>();
}

}  // namespace dvdx::bench
