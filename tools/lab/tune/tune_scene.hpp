// Finds the cheapest way to run a scene within an error.
#pragma once

#include <functional>

#include "report/simulation.hpp"
#include "state/loaded_scene.hpp"
#include "tune/tuning.hpp"

namespace dvdx::tool::tune {

struct SearchOptions {
  double goal = 1e-3;   // relative
  double seconds = 60;  // limit for reference and search together
  Thoroughness thoroughness = Thoroughness::search;
};

using ProgressCallback = std::function<void(double part, const std::string& what)>;

// `options` are those the scene was read with.
[[nodiscard]] Tuning tune_scene(const SceneOptions& options, const SearchOptions& wish, const report::Setup& setup,
                                const ProgressCallback& tell);

}  // namespace dvdx::tool::tune
