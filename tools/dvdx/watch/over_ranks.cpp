#include "watch/over_ranks.hpp"

#include <array>
#include <span>

#include "dvdx/layouts/state_hash.hpp"
#include "ranks/agree.hpp"
#include "state/refusal.hpp"
#include "watch/energy.hpp"

namespace dvdx::tool {

template <class T>
std::uint64_t state_hash(Ranks& ranks, const State<T>& state) {
  return in_turn(ranks, empty_state_hash, [&](std::uint64_t before) { return dvdx::state_hash(state, before); });
}

template <class T>
double energy(Ranks& ranks, const SceneFile& file, std::span<const Network> networks, const State<T>& state) {
  EnergySum sum;
  const Held held = held_by(ranks, file);
  add_particles(file, state, held, sum);
  add_networks(file, networks, state, held, sum);
  return sum.value();
}

Health combined(Ranks& ranks, const Health& mine) {
  std::uint64_t bad = mine.bad_particles;
  double largest = mine.largest;
  ranks.sum(std::span(&bad, 1));
  ranks.highest(std::span(&largest, 1));
  return {.bad_particles = bad, .largest = largest};
}

PartContext elsewhere_of(Ranks& ranks, const SceneFile& file) {
  const PartContext mine = dvdx::elsewhere_of(file.scene, file.particles.count);
  std::array<double, 3> numbers{mine.W, mine.g, mine.anchors_differ ? 1.0 : 0.0};
  ranks.highest(numbers);
  return {.W = numbers[0], .g = numbers[1], .anchors_differ = numbers[2] != 0};
}

double longest(Ranks& ranks, double seconds) {
  ranks.highest(std::span(&seconds, 1));
  return seconds;
}

template std::uint64_t state_hash(Ranks&, const State<float>&);
template std::uint64_t state_hash(Ranks&, const State<double>&);
template double energy(Ranks&, const SceneFile&, std::span<const Network>, const State<float>&);
template double energy(Ranks&, const SceneFile&, std::span<const Network>, const State<double>&);

}  // namespace dvdx::tool
