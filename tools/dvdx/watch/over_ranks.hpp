// Results for a state of which each of several ranks holds a range of particles. They equal those of one rank to the last bit.
#pragma once

#include <cstdint>

#include "dvdx/elsewhere.hpp"
#include "dvdx/layouts/state.hpp"
#include "dvdx/ranks.hpp"
#include "scene_io/scene_file.hpp"
#include "state/health.hpp"

namespace dvdx::tool {

// Pass from rank to rank in the order of the particles.
template <class T>
[[nodiscard]] std::uint64_t state_hash(Ranks& ranks, const State<T>& state);
template <class T>
[[nodiscard]] double energy(Ranks& ranks, const SceneFile& file, std::span<const Network> networks, const State<T>& state);
[[nodiscard]] Health combined(Ranks& ranks, const Health& mine);

// Returns the Options::elsewhere of all ranks together.
[[nodiscard]] PartContext elsewhere_of(Ranks& ranks, const SceneFile& file);

// Returns the time in s of the slowest rank.
[[nodiscard]] double longest(Ranks& ranks, double seconds);

extern template std::uint64_t state_hash(Ranks&, const State<float>&);
extern template std::uint64_t state_hash(Ranks&, const State<double>&);
extern template double energy(Ranks&, const SceneFile&, std::span<const Network>, const State<float>&);
extern template double energy(Ranks&, const SceneFile&, std::span<const Network>, const State<double>&);

}  // namespace dvdx::tool
