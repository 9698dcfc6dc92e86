// The forms in which a scene gives a value for each particle: alike, listed, drawn, or from a file.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "fields.hpp"
#include "scene_file.hpp"

namespace dvdx::tool {

// Where values per particle come from, and for how many particles.
struct Population {
  std::optional<std::size_t> count;  // not known where a mesh makes the particles
  std::filesystem::path folder;      // of the scene, which files are relative to
};

[[nodiscard]] Vectors read_vectors(const Node& node, const Population& population);
[[nodiscard]] Scalars read_scalars(const Node& node, const Population& population, const Range& range);
[[nodiscard]] std::vector<std::size_t> read_ids(const Node& node, const Population& population);

// Every particle's own vector.
[[nodiscard]] std::vector<Vec3> each_of(const Vectors& vectors, std::size_t count);

}  // namespace dvdx::tool
