// The positions that the particles of a run should have.
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

// Returns the closed form if the scene has one, otherwise a run in float64 with steps of an eighth that advances along with the
// states. `loaded` must outlive it. Throws Fault (bad_scene) if no plan can be made.
[[nodiscard]] RunReference reference_of(const LoadedScene& loaded, const Engine& engine);

}  // namespace dvdx::tool
