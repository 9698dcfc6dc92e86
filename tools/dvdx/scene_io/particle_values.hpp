// The forms in which a scene gives a value for each particle: alike, listed, drawn, or from a file.
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

// A seed may be any number of 64 bits: the most that one can be.
inline constexpr std::uint64_t any_seed = std::numeric_limits<std::uint64_t>::max();

// Where values per particle come from, and for how many particles.
struct Population {
  std::size_t count = 0;             // of the numbers that name them
  SceneFolder* folder = nullptr;     // never null where values are read
  std::string_view of = "particle";  // what the values are of
  std::optional<Run> kept{};         // of these alone; none: of all
  // Where numbers are not the particles' own; else null. A particle has the value of its first number.
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

// The particle of a number; none: it is left out.
[[nodiscard]] std::optional<std::size_t> particle_of(std::size_t number, const Population& population);
// The particle of a number that the node names, which may not be left out: something acts on it.
[[nodiscard]] std::size_t read_particle(const Node& node, const Population& population);
// The particles of numbers, each once: those that are left out are passed over.
[[nodiscard]] std::vector<std::size_t> particles_of(const std::vector<std::size_t>& numbers, const Population& population);
[[nodiscard]] std::vector<std::size_t> read_ids(const Node& node, const Population& population);  // numbers, each once

// The anchor of a force; null where it has none.
[[nodiscard]] inline const Anchor* anchor_of(const Force& force) noexcept {
  const auto find = [](const auto& f) -> const Anchor* {
    if constexpr (requires { f.anchor; }) return &f.anchor;
    return nullptr;
  };
  return std::visit(find, force);
}

// Every particle's own vector.
[[nodiscard]] std::vector<Vec3> each_of(const Vectors& vectors, std::size_t count);

}  // namespace dvdx::tool
