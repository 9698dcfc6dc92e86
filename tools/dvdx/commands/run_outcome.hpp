// The texts that dvdx run prints.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "run/engine.hpp"
#include "run/loaded_scene.hpp"
#include "run/outcome.hpp"

namespace dvdx::tool {

// Whom the outcome tells of, as the scene numbers them.
void name_particles(const Numbering& numbering, Outcome& outcome);

// A line.
[[nodiscard]] std::string text_of(const MeshNetwork& mesh);

// At the end.
[[nodiscard]] std::size_t particles_of(const LoadedScene& loaded, const Outcome& outcome);

// For a run that diverged.
[[nodiscard]] std::string why_diverged(const Outcome& outcome, std::size_t particles);

// ranks: where a launcher started them.
void print_outcome_json(const LoadedScene& loaded, const Engine& engine, const Outcome& outcome,
                        const std::vector<Warning>& warnings, std::optional<int> ranks);
void print_table(const LoadedScene& loaded, const Engine& engine, const Outcome& outcome, std::optional<int> ranks);

// The scene's own and the run's.
[[nodiscard]] std::vector<Warning> warnings_of(const LoadedScene& loaded, const Outcome& outcome);
void print_warnings(const std::string& scene, const std::vector<Warning>& warnings);

// While it runs, at once, and to be among its warnings. seconds: that the steps that are left take.
void tell_dear(double seconds, const SceneFile& file, Outcome& outcome);

}  // namespace dvdx::tool
