// The subcommands. Each function adds one to the command line; its callback does the work and sets the exit code.
#pragma once

#include "scene_io/fault.hpp"

namespace CLI {
class App;
}

namespace dvdx::tool {

void add_new(CLI::App& app, Exit& exit);
void add_run(CLI::App& app, Exit& exit);
void add_report(CLI::App& app, Exit& exit);
void add_tune(CLI::App& app, Exit& exit);
void add_explain(CLI::App& app, Exit& exit);
void add_verify(CLI::App& app, Exit& exit);
void add_stability(CLI::App& app, Exit& exit);
void add_merge(CLI::App& app, Exit& exit);
void add_info(CLI::App& app, Exit& exit);

}  // namespace dvdx::tool
