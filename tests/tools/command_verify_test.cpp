// dvdx verify and dvdx stability, and meshes in all commands.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tools/command_folders.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace command_folders::verify_test {

using dvdx::test::run;
using nlohmann::json;

TEST_CASE("run, explain and verify take a mesh that grains fall on, and an open mesh is exit 3") {
  const ScratchFolder folder("mesh-contact");
  const std::string corners = "v -1 -1 -1\nv 1 -1 -1\nv 1 -1 1\nv -1 -1 1\nv 0 0 0\n";
  folder.write("roof.obj", corners + "f 1 2 3 4\nf 1 5 2\nf 2 5 3\nf 3 5 4\nf 4 5 1\n");
  folder.write("open.obj", corners + "f 1 5 2\nf 2 5 3\nf 3 5 4\nf 4 5 1\n");
  folder.write("scene.json", R"({"format": "dvdx-scene/1", "name": "roof", "step": 0.01, "duration": 0.6,
    "particles": {"count": 100, "position": {"uniform": {"min": [-0.8, 0.1, -0.8], "max": [0.8, 0.5, 0.8], "seed": 3}}},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "contacts": [{"type": "mesh", "file": "roof.obj", "cell": 0.1, "restitution": 0.2}]})");
  const auto result = run(folder, "run scene.json --json --out roof.csv --every 60");
  CAPTURE(result.err);
  REQUIRE(result.exit == 0);
  const auto report = json::parse(result.out);
  CHECK(report["contacts"][0]["hits"] >= 100);
  CHECK(report["contacts"][0]["impulse"][1] < 0);
  const auto told = run(folder, "explain scene.json");
  CHECK(told.out.find("meshes       contacts[0]: 28 x 18 x 28 nodes, 56448 bytes, cells of 0.1 m: ") != std::string::npos);
  CHECK(run(folder, "verify scene.json").exit == 0);
  CHECK(run(folder, "run scene.json --out roof.html").exit == 0);
  const auto refused = run(folder, "run scene.json --set contacts[0].file=open.obj");
  CHECK(refused.exit == 3);
  CHECK(refused.err.starts_with("dvdx: scene.json: contacts[0].file is of an edge that only one triangle has: must be "));
}

TEST_CASE("verify holds a scene with a network against the reference") {
  const SheetFolder folder("verify");
  const auto result = run(folder, "verify sheet.json --json");
  CAPTURE(result.err);
  CHECK(result.exit == 0);
  const auto report = json::parse(result.out);
  CHECK(report["passed"] == true);
  REQUIRE(report["scenes"].size() == 3);
  CHECK(report["scenes"][0]["steps"] == 16);
  CHECK(report["scenes"][0]["sample"]["particles"] == 30);  // all: each one influences the others
  const auto& fast = report["scenes"][0]["fast"];
  CHECK(fast["isas"] == report["scenes"][0]["contracted"]["isas"]);
  CHECK(fast["first_step"]["ulps"].get<double>() > 0);
  CHECK(fast["first_step"]["ulps"] <= fast["first_step"]["at_most"]);

  const auto alone = json::parse(run(folder, "verify sheet.json --json --arithmetic fast").out);
  CHECK(alone["passed"] == true);
  CHECK(alone["scenes"][0]["fast"] == fast);
  CHECK(alone["scenes"][0]["isas"].empty());
  CHECK(alone["scenes"][0]["contracted"]["isas"].empty());
  CHECK(alone["scenes"][0]["runs"] < report["scenes"][0]["runs"]);
  CHECK(run(folder, "verify sheet.json --arithmetic exact").exit == 2);
}

TEST_CASE("verify holds particles that come and go against the reference") {
  const ScratchFolder folder("command-verify-jet");
  folder.write("jet.json", jet);
  const auto result = run(folder, "verify jet.json --json");
  CAPTURE(result.err);
  CHECK(result.exit == 0);
  const auto report = json::parse(result.out);
  CHECK(report["passed"] == true);
  CHECK(report["scenes"][0]["steps"] == 128);
  CHECK(report["scenes"][0]["particles"].get<int>() > 20);
}

TEST_CASE("stability runs the requested cases, and writes their results") {
  const Folder folder("stability");
  const auto result = run(folder, "stability --only cases --cases 25,24 --json --out found");
  CHECK(result.exit == 0);
  const auto found = json::parse(result.out);
  CHECK(found["machine"]["isas"].size() >= 1);
  REQUIRE(found["cases"].size() == 4);
  CHECK(found["cases"][0]["number"] == 24);
  CHECK(found["cases"][3]["number"] == 25);
  CHECK(found["cases"][3]["precision"] == "float32");
  // Every instruction set of the machine once, and those with fused operations once more.
  const auto& isas = found["cases"][3]["isas"];
  CHECK(isas.size() >= found["machine"]["isas"].size());
  for (const auto& isa : found["machine"]["isas"]) CHECK(std::count(isas.begin(), isas.end(), isa) == 1);
  CHECK(json::parse(folder.read("found/stability.json")) == found);
  CHECK(folder.entries() == 2);
}

TEST_CASE("stability refuses unknown cases, and an --out that it cannot write to") {
  const Folder folder("stability-usage");
  for (const char* arguments : {"--cases 0", "--cases 99", "--cases some", "--only pictures"}) {
    CAPTURE(arguments);
    CHECK(run(folder, std::string("stability ") + arguments).exit == 2);
  }
  CHECK(run(folder, "stability --cases 25 --only cases --out fall.json").exit == 4);
}

}  // namespace command_folders::verify_test
