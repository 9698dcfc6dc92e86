// Options that several commands have.
#pragma once

#include "state/engine.hpp"
#include "state/loaded_scene.hpp"

namespace CLI {
class App;
}

namespace dvdx::tool {

// Options that choose the scene and replace values in it.
void add_scene_options(CLI::App& app, SceneOptions& options);
// The subset that replaces values but not the way in which the scene is stepped.
void add_scene_replacements(CLI::App& app, SceneOptions& options);

// Options of how the scene is run.
void add_engine_options(CLI::App& app, EngineOptions& options);
// The same without the precision.
void add_machine_options(CLI::App& app, EngineOptions& options);

}  // namespace dvdx::tool
