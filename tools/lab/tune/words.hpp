// A candidate as command line options and as settings of a scene file.
#pragma once

#include <string>
#include <vector>

#include "state/loaded_scene.hpp"
#include "tune/candidates.hpp"

namespace dvdx::tool::tune {

// The paths of a scene's networks in its file: "network", or "network[0]", "network[1]", ...
[[nodiscard]] std::vector<std::string> network_paths(const SceneOptions& options);

// The number of seeds of random values in the scene.
[[nodiscard]] std::size_t seeds_in(const SceneOptions& options);

// The words after `dvdx run` that run the scene as the candidate does; the scene and the replacements in it come first.
[[nodiscard]] std::vector<std::string> run_options(const SceneOptions& options, const SceneFile& file,
                                                   const Candidate& candidate);

// The same as lines of the file: path and value. Precision is not part of the file.
[[nodiscard]] std::vector<std::string> scene_lines(const SceneOptions& options, const SceneFile& file,
                                                   const Candidate& candidate);

}  // namespace dvdx::tool::tune
