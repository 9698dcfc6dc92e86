// Which scenes can be split over several ranks, and which cannot.
#pragma once

#include <filesystem>

#include "dvdx/ranks.hpp"
#include "ranks/range_exchange.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// Whether each rank holds a range of the particles: nothing joins them, and none come or go.
[[nodiscard]] inline bool is_split_by_ranges(const SceneFile& file, const Ranks& ranks) noexcept {
  return ranks.count() > 1 && !is_joined(file.scene) && !is_live(file);
}

// Whether each rank steps a part of a scene of joined particles.
[[nodiscard]] inline bool is_split_by_springs(const SceneFile& file, const Ranks& ranks) noexcept {
  return ranks.count() > 1 && is_joined(file.scene);
}

// Whether particles come and go, and each rank steps those that it makes.
[[nodiscard]] inline bool is_split_by_births(const SceneFile& file, const Ranks& ranks) noexcept {
  return ranks.count() > 1 && is_live(file);
}

// Returns the range of particles that this rank shows at the start, whichever it steps; one rank shows all. `file` holds all
// particles of a joined scene, otherwise those of this rank's range alone.
[[nodiscard]] inline Run shown_by(const SceneFile& file, const Ranks& ranks) noexcept {
  if (is_split_by_springs(file, ranks)) return share_of(ranks).of(file.particles.count);
  return {.first = file.particles.first, .count = file.particles.count};
}

// Returns which particles of `file` the state that this rank shows has. Particles that come and go are all alike.
[[nodiscard]] inline Held held_by(Ranks& ranks, const SceneFile& file) noexcept {
  if (ranks.count() == 1) return {};
  return {.ranks = &ranks, .first = is_split_by_springs(file, ranks) ? shown_by(file, ranks).first : 0};
}

// Throws Fault: bad_scene, naming the part of a scene that cannot be split; usage if its output cannot be.
void check_can_be_split(const SceneFile& file, const std::filesystem::path& out);

}  // namespace dvdx::tool
