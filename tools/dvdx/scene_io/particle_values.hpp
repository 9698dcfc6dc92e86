// The forms in which a scene gives a value for each particle: the same for all, listed, drawn, or from a file.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "scene_io/fields.hpp"
#include "scene_io/numbering.hpp"
#include "scene_io/points_file.hpp"
#include "scene_io/scene_file.hpp"
#include "scene_io/scene_folder.hpp"

namespace dvdx::tool {

// The largest seed: a seed may be any number of 64 bits.
inline constexpr std::uint64_t any_seed = std::numeric_limits<std::uint64_t>::max();

// The source of values per particle, and the number of particles.
struct Population {
  std::size_t count = 0;             // of the numbers that name particles
  SceneFolder* folder = nullptr;     // never null if values are read
  std::string_view of = "particle";  // the things that have the values
  std::optional<Run> kept{};         // the part that is kept; none: all
  // Null if numbers are the particles' own. Otherwise a particle has the value of its first number.
  const Numbering* numbering = nullptr;

  [[nodiscard]] Run run() const noexcept { return kept.value_or(Run{.first = 0, .count = count}); }
  [[nodiscard]] std::size_t number_of(std::size_t particle) const noexcept {
    return numbering == nullptr ? particle : numbering->number_of(particle);
  }
};

// The memory that the particles may take.
struct Room {
  std::uint64_t bytes_each = 1;
  std::uint64_t bytes = 0;  // in all

  [[nodiscard]] std::uint64_t most() const noexcept { return bytes / bytes_each; }
  // "at most 10: a particle of this scene takes ..."
  [[nodiscard]] std::string limit() const;
};

[[nodiscard]] Vectors read_vectors(const Node& node, const Population& population);
[[nodiscard]] Scalars read_scalars(const Node& node, const Population& population, const Range& range);

// Returns the particle of a number, or none if it is left out.
[[nodiscard]] std::optional<std::size_t> particle_of(std::size_t number, const Population& population);
// Returns the particle of the number that the node names. It may not be left out, because something acts on it.
[[nodiscard]] std::size_t read_particle(const Node& node, const Population& population);
// Returns the particles of numbers, each once. Numbers that are left out are skipped.
[[nodiscard]] std::vector<std::size_t> particles_of(const std::vector<std::size_t>& numbers, const Population& population);
[[nodiscard]] std::vector<std::size_t> read_ids(const Node& node, const Population& population);  // numbers, each once

// Returns the anchor of a force, or null if it has none.
[[nodiscard]] inline const Anchor* anchor_of(const Force& force) noexcept {
  const auto find = [](const auto& f) -> const Anchor* {
    if constexpr (requires { f.anchor; }) return &f.anchor;
    return nullptr;
  };
  return std::visit(find, force);
}

// Returns every particle's own vector.
[[nodiscard]] std::vector<Vec3> each_of(const Vectors& vectors, std::size_t count);

}  // namespace dvdx::tool
