// The texts that dvdx run prints.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "state/engine.hpp"
#include "state/loaded_scene.hpp"
#include "watch/outcome.hpp"

namespace dvdx::tool {

// Replaces the particle indices in the outcome by the scene's own numbers.
void name_particles(const Numbering& numbering, Outcome& outcome);
// Returns one line about a mesh.
[[nodiscard]] std::string text_of(const MeshNetwork& mesh);
// ranks: the number of ranks if a launcher started them.
void print_outcome_json(const LoadedScene& loaded, const Engine& engine, const Outcome& outcome,
                        const std::vector<Warning>& warnings, std::optional<int> ranks);
void print_table(const LoadedScene& loaded, const Engine& engine, const Outcome& outcome, std::optional<int> ranks);

}  // namespace dvdx::tool
