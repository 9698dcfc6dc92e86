// Draws other values for the same scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>

namespace dvdx::tool {

// Counts the seeds in a scene's JSON: one in each {"uniform": {..., "seed": s}} and {"lattice": {..., "seed": s}}.
[[nodiscard]] std::size_t count_seeds(const nlohmann::json& scene);

// Replaces each seed s by a function of (s, seed): seeds that were alike stay alike, and others differ.
void reseed(nlohmann::json& scene, std::uint64_t seed);

}  // namespace dvdx::tool
