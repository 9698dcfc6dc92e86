// The number of particles that a scene may have in the available memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "scene_io/particle_values.hpp"
#include "scene_io/scene_reader.hpp"

namespace dvdx::tool {

inline constexpr std::uint64_t most_particles = std::uint64_t{1} << 53U;

// Return the room for particles that come and go, and for those that networks make.
[[nodiscard]] Room room_for_live(const nlohmann::json& scene, const ReadOptions& options);
[[nodiscard]] Room room_for_networks(const nlohmann::json& scene, const ReadOptions& options);

// Whether each particle moves by itself, so that a rank may hold some of them without the others.
[[nodiscard]] bool can_split_by_ranges(const nlohmann::json& scene);

// Returns the number of particles that the scene lists itself. They must find room.
[[nodiscard]] std::size_t read_count(const Node& node, const nlohmann::json& scene, const ReadOptions& options);

}  // namespace dvdx::tool
