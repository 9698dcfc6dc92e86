// The command refuses wrong input, with a specific exit status for each kind.
#include <doctest/doctest.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/command_folders.hpp"
#include "tools/run_command.hpp"

namespace command_folders::refusal_test {

using dvdx::test::run;
using nlohmann::json;

TEST_CASE("an unknown command is named, with the list of known ones") {
  const auto result = run(Folder("walk"), "walk fall.json");
  CHECK(result.exit == 2);
  CHECK(result.err ==
        "dvdx: walk is not a command: known are new, run, report, tune, explain, verify, stability, merge, info, help\n");
}

TEST_CASE("a usage error is exit 2, with a message on stderr alone") {
  const Folder folder("usage");
  for (const char* arguments : {"",
                                "walk fall.json",
                                "run",
                                "run fall.json --speed 3",
                                "run fall.json --precision float16",
                                "run fall.json --isa mmx",
                                "run fall.json --layout rows",
                                "run fall.json --method verlet",
                                "run fall.json --threads 0",
                                "run fall.json --every -1",
                                "run fall.json --fps 0",
                                "run fall.json --fps inf",
                                "run fall.json --fps 30 --every 2",
                                "help walk",
                                "new cloth",
                                "new snow a.json",
                                "run fall.json --step 0",
                                "run fall.json --step nan",
                                "run fall.json --step 0.3",
                                "run fall.json --duration -1",
                                "run fall.json --out a.xyz",
                                "run fall.json --set stiffness",
                                "run fall.json --scheme leapfrog",
                                "run fall.json --substeps 4",
                                "run fall.json --isa sse2 --arithmetic contracted",
                                "run fall.json --step 1e9",
                                "run fall.json --every 0x10",
                                "run fall.json --threads 010",
                                "run fall.json --seed -1",
                                "run fall.json --seed +1",
                                "run fall.json --seed 18446744073709551616",
                                "run fall.json --checkpoint a --checkpoint-every 0",
                                "run fall.json --step ''",
                                "run fall.json --every ''",
                                "run fall.json --out ''",
                                "run fall.json --resume ''",
                                "run fall.json --substeps ''",
                                "run ''",
                                "stability --cases 03",
                                "tune fall.json --error 0",
                                "tune fall.json --error inf",
                                "explain fall.json --ranks 1e3",
                                "explain fall.json --ranks 2 --latency -1"}) {
    CAPTURE(std::string(arguments));
    const auto result = run(folder, arguments);
    CHECK(result.exit == 2);
    CHECK(result.out.empty());
    CHECK_FALSE(result.err.empty());
  }
  CHECK(run(folder, "run fall.json --isa mmx").err.find("there are best, reference") != std::string::npos);
  CHECK(run(folder, "run fall.json", "DVDX_ISA=mmx").exit == 2);
  CHECK(run(folder, "run fall.json", "DVDX_ISA=reference").exit == 0);
  for (const char* const command : {"info", "info --json", "explain fall.json", "stability --cases 3"}) {
    const auto result = run(folder, command, "DVDX_ISA=mmx");
    CHECK(result.exit == 2);
    CHECK(result.out.empty());
    CHECK(result.err.starts_with("dvdx: DVDX_ISA mmx: no such instruction set: with separate arithmetic there are best, ref"));
  }
  CHECK(folder.entries() == 1);
}

TEST_CASE("a number that an option cannot take is named with the valid range") {
  const Folder folder("numbers");
  CHECK(run(folder, "run fall.json --seed -1")
            .err.starts_with("--seed: -1: must be a whole number from 0 to 18446744073709551615\n"));
  CHECK(run(folder, "run fall.json --threads 010").err.starts_with("--threads: 010: must be a whole number from 1 to 1024\n"));
  CHECK(run(folder, "tune fall.json --error x").err.starts_with("--error: x: must be a finite number > 0\n"));
  CHECK(run(folder, "run fall.json --every ''").err.starts_with("--every: nothing: must be a whole number from 0 to "));
  CHECK(run(folder, "run fall.json --resume ''").err.starts_with("--resume: must not be empty\n"));
  CHECK(run(folder, "run fall.json --seed 18446744073709551615").exit == 0);
}

TEST_CASE("a run refuses one file for two of its outputs, or for an output and --resume") {
  const Folder folder("same-file");
  REQUIRE(run(folder, "run fall.json --checkpoint c.csv --checkpoint-every 3").exit == 0);
  const auto checkpoint = folder.read("c.csv");
  const std::string same = folder.path().string();
  for (const std::string& arguments :
       {"--out a.csv --events ./a.csv"s, "--out a.csv --checkpoint '" + same + "/a.csv' --checkpoint-every 3",
        "--out c.csv --resume ./c.csv"s, "--events c.csv --resume c.csv"s,
        "--events a.csv --checkpoint a.csv --checkpoint-every 3"s}) {
    CAPTURE(arguments);
    const auto result = run(folder, "run fall.json " + arguments);
    CHECK(result.exit == 2);
    CHECK(result.err.find(": must be another file than that of --") != std::string::npos);
  }
  CHECK(folder.entries() == 2);
  CHECK(folder.read("c.csv") == checkpoint);
}

TEST_CASE("a bad scene is exit 3, named, and nothing is written") {
  const Folder folder("bad-scene");
  const auto result = run(folder, "run fall.json --set forces[1].stiffness=-3 --out a.csv");
  CHECK(result.exit == 3);
  CHECK(result.out.empty());
  CHECK(result.err == "dvdx: fall.json: forces[1].stiffness is -3: must be a finite number >= 0\n");
  CHECK(run(folder, "run fall.json --set particles.count=1000000000000000").exit == 3);
  CHECK(run(folder, "explain fall.json --set particles.mass=0").exit == 3);
  CHECK(folder.entries() == 1);
}

TEST_CASE("a file that cannot be read or written is exit 4, and nothing is written") {
  const Folder folder("files");
  for (const char* arguments : {"run none.json", "run .", "run fall.json --out none/a.csv", "explain none.json"}) {
    CAPTURE(std::string(arguments));
    const auto result = run(folder, arguments);
    CHECK(result.exit == 4);
    CHECK(result.out.empty());
    CHECK(result.err.starts_with("dvdx: "));
  }
  CHECK(folder.entries() == 1);
}

TEST_CASE("a simulation that diverges is exit 5, and says so in its output") {
  const Folder folder("diverged");
  const std::string unstable = "run fall.json --method symplectic_euler --set forces[1].stiffness=1e6 --duration 125 --json";
  const auto result = run(folder, unstable + " --out a.csv");
  CHECK(result.exit == 5);
  CHECK(result.err.find("diverged") != std::string::npos);
  const auto report = json::parse(result.out);
  CHECK(report["diverged"] == true);
  CHECK(report["bad_particles"] == 19);  // all but the fixed one
  CHECK(report["energy"]["end"].is_null());
  CHECK(report["warnings"].back()["cure"] == "Try --method combined");
  CHECK(run(folder, "run fall.json --method combined --set forces[1].stiffness=1e6 --duration 125").exit == 0);
  CHECK(result.err == "dvdx: fall.json: the simulation diverged: 19 of 20 particles are not finite\n");
  const auto table = run(folder, unstable.substr(0, unstable.find(" --json")));
  CHECK(table.out.find(" at the start, not finite at the end") != std::string::npos);
  CHECK_FALSE(folder.read("a.csv").empty());
}

TEST_CASE("run refuses sub-steps that are invalid or too many, and run and explain refuse too few") {
  const SheetFolder folder("substeps");
  for (const char* substeps : {"0", "-1", "1000001", "2.5", "some", "3x"}) {
    CAPTURE(std::string(substeps));
    CHECK(run(folder, std::string("run sheet.json --substeps=") + substeps).exit == 2);
  }
  const auto unstable = run(folder, "run sheet.json --set network.structural=4e4 --substeps 1");
  CHECK(unstable.exit == 3);
  CHECK(unstable.err.starts_with("dvdx: sheet.json: network.substeps is 1: must be at least "));
  CHECK(run(folder, "explain sheet.json").exit == 0);
  CHECK(run(folder, "explain sheet.json --set network.structural=4e4 --substeps 1").exit == 3);
}

}  // namespace command_folders::refusal_test
