// A candidate in the words of the command line and of a scene file.
#pragma once

#include <string>
#include <vector>

#include "state/loaded_scene.hpp"
#include "tune/candidates.hpp"

namespace dvdx::tool::tune {

// The paths of a scene's networks in its file: "network", or "network[0]", "network[1]", ...
[[nodiscard]] std::vector<std::string> network_paths(const SceneOptions& options);

// The number of seeds of values that the scene draws.
[[nodiscard]] std::size_t seeds_in(const SceneOptions& options);

// The words by which `dvdx run` runs the scene so, the scene and what was replaced in it first.
[[nodiscard]] std::vector<std::string> run_options(const SceneOptions& options, const SceneFile& file,
                                                   const Candidate& candidate);

// The same as lines of the file: a path and its value. The precision has none.
[[nodiscard]] std::vector<std::string> scene_lines(const SceneOptions& options, const SceneFile& file,
                                                   const Candidate& candidate);

}  // namespace dvdx::tool::tune
