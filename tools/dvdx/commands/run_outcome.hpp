// The texts that dvdx run prints.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "state/engine.hpp"
#include "state/loaded_scene.hpp"
#include "watch/outcome.hpp"

namespace dvdx::tool {

// Whom the outcome tells of, as the scene numbers them.
void name_particles(const Numbering& numbering, Outcome& outcome);
// A line.
[[nodiscard]] std::string text_of(const MeshNetwork& mesh);
// ranks: where a launcher started them.
void print_outcome_json(const LoadedScene& loaded, const Engine& engine, const Outcome& outcome,
                        const std::vector<Warning>& warnings, std::optional<int> ranks);
void print_table(const LoadedScene& loaded, const Engine& engine, const Outcome& outcome, std::optional<int> ranks);

}  // namespace dvdx::tool
