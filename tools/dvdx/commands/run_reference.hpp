// Where the particles of a run should be.
#pragma once

#include <string>

#include "output/writer.hpp"
#include "state/engine.hpp"
#include "state/loaded_scene.hpp"

namespace dvdx::tool {

struct RunReference {
  ReferencePositions positions;
  std::string text;  // what it is: "the closed form"
};

// The closed form where the scene has one; else a run in float64 with steps of an eighth, which is made along with the states.
// `loaded` must outlive it. Throws Fault (bad_scene) where no plan can be made.
[[nodiscard]] RunReference reference_of(const LoadedScene& loaded, const Engine& engine);

}  // namespace dvdx::tool
