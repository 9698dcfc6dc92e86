// Results for a state whose particles several ranks hold, each a range of them: the same, to the last bit, as for one rank's.
#pragma once

#include <cstdint>

#include "dvdx/elsewhere.hpp"
#include "dvdx/layouts/state.hpp"
#include "dvdx/ranks.hpp"
#include "scene_io/scene_file.hpp"
#include "state/health.hpp"

namespace dvdx::tool {

// From rank to rank in the order of the particles.
template <class T>
[[nodiscard]] std::uint64_t state_hash(Ranks& ranks, const State<T>& state);
template <class T>
[[nodiscard]] double energy(Ranks& ranks, const SceneFile& file, std::span<const Network> networks, const State<T>& state);
[[nodiscard]] Health combined(Ranks& ranks, const Health& mine);

// The Options::elsewhere of all ranks together.
[[nodiscard]] PartContext elsewhere_of(Ranks& ranks, const SceneFile& file);

// Seconds that the slowest rank took.
[[nodiscard]] double longest(Ranks& ranks, double seconds);

extern template std::uint64_t state_hash(Ranks&, const State<float>&);
extern template std::uint64_t state_hash(Ranks&, const State<double>&);
extern template double energy(Ranks&, const SceneFile&, std::span<const Network>, const State<float>&);
extern template double energy(Ranks&, const SceneFile&, std::span<const Network>, const State<double>&);

}  // namespace dvdx::tool
