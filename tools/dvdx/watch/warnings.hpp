// Warnings of a run, each with its cure.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "state/loaded_scene.hpp"
#include "watch/outcome.hpp"

namespace dvdx::tool {

// Returns the number of particles at the end.
[[nodiscard]] std::size_t particles_of(const LoadedScene& loaded, const Outcome& outcome);
// Says why a run diverged.
[[nodiscard]] std::string why_diverged(const Outcome& outcome, std::size_t particles);
// Returns the ends of a spring as text.
[[nodiscard]] std::string ends_text(const Pair& ends);

// The scene's own warnings and the run's.
[[nodiscard]] std::vector<Warning> warnings_of(const LoadedScene& loaded, const Outcome& outcome);
void print_warnings(const std::string& scene, const std::vector<Warning>& warnings);
// Prints a warning at once, during the run, and adds it to the outcome. seconds: the time of the steps that are left.
void warn_of_long_run(double seconds, const SceneFile& file, Outcome& outcome);

}  // namespace dvdx::tool
