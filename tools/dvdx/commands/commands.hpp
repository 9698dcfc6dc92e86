// The subcommands: each adds itself to the command line and, where the user asks for it, does its work and sets the exit code.
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
