// Commands that a short build leaves out, as DVDX_LAB of the build says. Each names the command that builds it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "commands/commands.hpp"

namespace dvdx::tool {
namespace {

void add_left_out(CLI::App& app, const std::string& name, const std::string& builds) {
  auto* command = app.add_subcommand(name, fmt::format("Not in this build: `{}` builds it", builds));
  command->footer("dvdx " + name + " scene.json");
  command->allow_extras();  // any arguments lead to the message below
  command->callback([name, builds] {
    throw Fault(Exit::usage, fmt::format("{} is not in this build, which leaves out what a first run does not need: `{}` in "
                                         "dvdx's source builds it (or cmake -DDVDX_LAB=all)",
                                         name, builds));
  });
}

}  // namespace

#ifdef DVDX_NO_REPORT
void add_report(CLI::App& app, Exit& /*exit*/) { add_left_out(app, "report", "tools/run.sh report"); }
void add_verify(CLI::App& app, Exit& /*exit*/) { add_left_out(app, "verify", "tools/run.sh verify"); }
#endif
#ifdef DVDX_NO_STABILITY
void add_tune(CLI::App& app, Exit& /*exit*/) { add_left_out(app, "tune", "tools/run.sh build"); }
void add_stability(CLI::App& app, Exit& /*exit*/) { add_left_out(app, "stability", "tools/run.sh build"); }
#endif

}  // namespace dvdx::tool
