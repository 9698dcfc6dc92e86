// The constraint pass: pairs that share no particle, and ropes.
#include <cstdint>
#include <optional>
#include <utility>

#include "support/benches.hpp"
#include "support/plan_bench.hpp"
#include "support/scenes.hpp"

namespace dvdx::bench {
namespace {

// Rods or ropes of `links` in a row, with the lengths of the start. The reference that results are compared with holds 4097
// particles, so the last of them is free in every batch.
Scene linked(std::size_t count, std::uint32_t links, Bound bound) {
  Scene scene = fall();
  Distance distance{.pairs = {}, .length = std::nullopt, .bound = bound};
  for (std::uint32_t i = 1; i < count; ++i) {
    if (i % (links + 1) != 0 && i / (links + 1) != 4096 / (links + 1)) distance.pairs.push_back({i - 1, i});
  }
  return scene.add(std::move(distance));
}

// Every particle falls onto its limit, 0.1 mm away, and hangs there; or it falls out of the ball behind it.
Scene on_a_skin(std::size_t count, bool is_near) {
  Scene scene = fall();
  Skin skin{.particles = {}, .points = {}, .at_most = is_near ? 1e-4 : 1e4};
  for (std::size_t i = 0; i < count; ++i) skin.particles.push_back(i);
  return scene.add(std::move(skin));
}

template <class T>
void add_linked(Pace pace) {
  add_in_cache<T>(pace, {.name = "constraint/rods", .scene = [](std::size_t n) { return linked(n, 1, Bound::equal); }});
  add_in_cache<T>(pace, {.name = "constraint/ropes_of_15", .scene = [](std::size_t n) { return linked(n, 15, Bound::equal); }});
  add_in_cache<T>(pace,
                  {.name = "constraint/strain_limits", .scene = [](std::size_t n) { return linked(n, 15, Bound::at_most); }});
  add_in_cache<T>(pace, {.name = "constraint/skin_near", .scene = [](std::size_t n) { return on_a_skin(n, true); }});
  add_in_cache<T>(pace, {.name = "constraint/skin_far", .scene = [](std::size_t n) { return on_a_skin(n, false); }});
}

}  // namespace

void register_constraint(Pace pace) {
  add_linked<float>(pace);
  add_linked<double>(pace);
}

}  // namespace dvdx::bench
