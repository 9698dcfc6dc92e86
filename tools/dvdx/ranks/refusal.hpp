// What can be split over several ranks, and what cannot.
#pragma once

#include <filesystem>

#include "dvdx/ranks.hpp"
#include "scene_io/scene_file.hpp"

namespace dvdx::tool {

// Whether each rank holds a range of the particles: where nothing joins them, and none come or go.
[[nodiscard]] inline bool is_split_by_ranges(const SceneFile& file, const Ranks& ranks) noexcept {
  return ranks.count() > 1 && !is_joined(file.scene) && !is_live(file);
}

// Whether each rank steps a part of a scene whose particles stand for one another, and the first has all of it besides.
[[nodiscard]] inline bool is_split_by_springs(const SceneFile& file, const Ranks& ranks) noexcept {
  return ranks.count() > 1 && is_joined(file.scene);
}

// Whether each rank steps the particles that it makes of those that come and go.
[[nodiscard]] inline bool is_split_by_births(const SceneFile& file, const Ranks& ranks) noexcept {
  return ranks.count() > 1 && is_live(file);
}

// Whether the first rank alone is told the whole state, which it shows.
[[nodiscard]] inline bool is_gathered(const SceneFile& file, const Ranks& ranks) noexcept {
  return is_split_by_springs(file, ranks) || is_split_by_births(file, ranks);
}

// Throws Fault (bad_scene) that names what of a scene cannot be split, and Fault (usage) where its output cannot.
void check_can_be_split(const SceneFile& file, const std::filesystem::path& out);

}  // namespace dvdx::tool
