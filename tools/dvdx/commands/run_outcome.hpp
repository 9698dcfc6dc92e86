// What dvdx run prints.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "commands/scene_options.hpp"
#include "run/engine.hpp"
#include "run/outcome.hpp"

namespace dvdx::tool {

// At the end.
[[nodiscard]] std::size_t particles_of(const LoadedScene& loaded, const Outcome& outcome);

// Of a run that did.
[[nodiscard]] std::string why_diverged(const Outcome& outcome, std::size_t particles);

// ranks: where a launcher started them.
void print_outcome_json(const LoadedScene& loaded, const Engine& engine, const Outcome& outcome, std::optional<int> ranks);
void print_table(const LoadedScene& loaded, const Engine& engine, const Outcome& outcome, std::optional<int> ranks);

// Where the run heated. scene: as typed.
void warn_of_heat(const std::string& scene, const LoadedScene& loaded, const Outcome& outcome);

}  // namespace dvdx::tool
