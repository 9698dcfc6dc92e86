// Warnings of a run, each with its cure.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "state/loaded_scene.hpp"
#include "watch/outcome.hpp"

namespace dvdx::tool {

// At the end.
[[nodiscard]] std::size_t particles_of(const LoadedScene& loaded, const Outcome& outcome);
// For a run that diverged.
[[nodiscard]] std::string why_diverged(const Outcome& outcome, std::size_t particles);
// The ends of a spring, in words.
[[nodiscard]] std::string ends_text(const Pair& ends);

// The scene's own and the run's.
[[nodiscard]] std::vector<Warning> warnings_of(const LoadedScene& loaded, const Outcome& outcome);
void print_warnings(const std::string& scene, const std::vector<Warning>& warnings);
// While it runs, at once, and to be among its warnings. seconds: that the steps that are left take.
void tell_dear(double seconds, const SceneFile& file, Outcome& outcome);

}  // namespace dvdx::tool
