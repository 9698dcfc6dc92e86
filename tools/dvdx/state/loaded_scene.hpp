// A scene as a run takes it: read from its file, with the values that the command line replaces.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dvdx/ranks.hpp"
#include "scene_io/scene_file.hpp"
#include "state/engine.hpp"

namespace dvdx::tool {

struct SceneOptions {  // as typed
  std::string scene;
  std::optional<double> step{};      // s; negative runs time backwards
  std::optional<double> duration{};  // s
  std::string method{};              // of every force and pair
  std::string scheme{};              // of the networks
  std::string substeps{};            // of the networks: a whole number or "auto"
  std::optional<std::uint64_t> seed{};
  std::vector<std::string> overrides{};
};

struct LoadedScene {
  SceneFile file;
  std::uint64_t steps = 0;
};

// Throws Fault: usage if an option cannot go with the scene, and all that read_scene throws. If the scene can be split by
// ranges, each of several ranks gets its part. All ranks choose the same origins.
[[nodiscard]] LoadedScene load_scene(const SceneOptions& options, Precision precision);
[[nodiscard]] LoadedScene load_scene(const SceneOptions& options, Precision precision, Ranks& ranks, ReadTopology topology);

}  // namespace dvdx::tool
