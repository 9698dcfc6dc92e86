// Options that several commands have.
#pragma once

#include "state/engine.hpp"
#include "state/loaded_scene.hpp"

namespace CLI {
class App;
}

namespace dvdx::tool {

// Which scene, and what of it is replaced.
void add_scene_options(CLI::App& app, SceneOptions& options);
// Those of these options that replace something in a scene without saying how it is stepped.
void add_scene_replacements(CLI::App& app, SceneOptions& options);

// How it is run.
void add_engine_options(CLI::App& app, EngineOptions& options);
// The same without the precision.
void add_machine_options(CLI::App& app, EngineOptions& options);

}  // namespace dvdx::tool
