// The command's help, dvdx explain, info and new.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tools/command_folders.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace command_folders::help_test {

using dvdx::test::run;
using nlohmann::json;

TEST_CASE("explain describes the scene, and info the instruction sets and threads") {
  const Folder folder("told");
  const auto explained = run(folder, "explain fall.json");
  CHECK(explained.exit == 0);
  CHECK(explained.out.find("20, 1 of them fixed") != std::string::npos);
  CHECK(run(folder, "info").exit == 0);
  const auto info = json::parse(run(folder, "info --json").out);
  CHECK(info["isas"]["separate"]["machine"][0] == "reference");
  CHECK(info["isas"]["fast"] == info["isas"]["contracted"]);
  CHECK(info["threads"].get<int>() >= 1);
  const auto forced = json::parse(run(folder, "info --json", "DVDX_ISA=reference").out);
  CHECK(forced["isas"]["separate"]["chosen"] == "reference");
  CHECK(run(folder, "info", "DVDX_ISA=reference").out.find("chosen: reference (by DVDX_ISA)") != std::string::npos);
#if defined(__x86_64__)  // where there is a set that fuses nothing
  CHECK(json::parse(run(folder, "info --json", "DVDX_ISA=sse2").out)["isas"]["contracted"]["chosen"].is_null());
  CHECK(run(folder, "info", "DVDX_ISA=sse2").out.find("chosen: none: DVDX_ISA asks for sse2") != std::string::npos);
#endif
  CHECK_FALSE(info["version"].get<std::string>().empty());
}

// The commands listed by `dvdx --help` after "Subcommands:", one a line: two spaces, the name, a description.
std::vector<std::string> subcommands(const std::string& help) {
  const std::string heading = "Subcommands:\n";
  REQUIRE(help.find(heading) != std::string::npos);
  std::istringstream lines(help.substr(help.find(heading) + heading.size()));
  std::vector<std::string> names;
  for (std::string line; std::getline(lines, line) && line.starts_with("  ");) {
    names.push_back(line.substr(2, line.find(' ', 2) - 2));
  }
  return names;
}

TEST_CASE("dvdx alone lists the commands, a line each, and an example; help says what one takes") {
  const Folder folder("alone");
  const auto alone = run(folder, "");
  CHECK(alone.exit == 2);
  CHECK(alone.err.find("\nExample:\n  dvdx run ") != std::string::npos);
  const auto help = run(folder, "help");
  CHECK(help.exit == 0);
  CHECK(help.out == alone.err);
  for (const auto& name : subcommands(run(folder, "--help").out)) {
    CAPTURE(name);
    CHECK(alone.err.find("\n  " + name + " ") != std::string::npos);
    const auto one = run(folder, "help " + name);
    CHECK(one.exit == 0);
    CHECK(one.out == run(folder, name + " --help").out);
  }
  CHECK(run(folder, "help walk").err.starts_with("dvdx: walk is not a command: known are new, run, "));
}

TEST_CASE("new writes scenes that run as they stand, and leaves existing files unchanged") {
  const ScratchFolder folder("command-new");
  for (const std::string kind : {"cloth", "rope", "fountain", "grains"}) {
    CAPTURE(kind);
    const auto made = run(folder, "new " + kind + " " + kind + ".json");
    CHECK(made.exit == 0);
    CHECK(made.out.find("dvdx run " + kind + ".json --out " + kind + ".html") != std::string::npos);
    const auto text = folder.read(kind + ".json");
    CHECK(json::parse(text)["about"].get<std::string>().find("Change first: ") != std::string::npos);
    const auto result = run(folder, "run " + kind + ".json --strict --duration 0.5");
    CAPTURE(result.err);
    CHECK(result.exit == 0);
    const auto again = run(folder, "new cloth " + kind + ".json");
    CHECK(again.exit == 4);
    CHECK(again.err.find("is there already") != std::string::npos);
    CHECK(folder.read(kind + ".json") == text);
  }
  CHECK(run(folder, "new rope none/rope.json").exit == 4);
  CHECK(folder.entries() == 4);
}

TEST_CASE("help of every subcommand starts with an example of it and is no error") {
  const Folder folder("help");
  const auto help = run(folder, "--help");
  CHECK(help.exit == 0);
  CHECK(help.out.starts_with("Example:\n  dvdx "));
  const auto names = subcommands(help.out);
  CHECK(names.size() >= 6);
  for (const auto& name : names) {
    CAPTURE(name);
    const auto result = run(folder, name + " --help");
    CHECK(result.exit == 0);
    CHECK(result.out.starts_with("Example:\n  dvdx " + name + " "));
  }
  CHECK(run(folder, "--version").exit == 0);
}

}  // namespace command_folders::help_test
