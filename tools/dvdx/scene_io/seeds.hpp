// Other drawn values for the same scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>

namespace dvdx::tool {

// Seeds in a scene's JSON: of each {"uniform": {..., "seed": s}}.
[[nodiscard]] std::size_t count_seeds(const nlohmann::json& scene);

// Each seed s becomes a function of (s, seed), so that seeds that were alike stay alike and others differ.
void reseed(nlohmann::json& scene, std::uint64_t seed);

}  // namespace dvdx::tool
