// One scene on several ranks: the same bits, the same files, the same refusals as on one.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/scene_reader.hpp"
#include "state/refusal.hpp"
#include "state/start.hpp"
#include "support/paths.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace ranks_test {

using dvdx::test::CommandResult;
using dvdx::test::run;
using dvdx::test::ScratchFolder;

// More ranks than cores, as root where the tests run in a container, and without a look for other machines, which takes
// longest.
std::string launcher(int ranks, const std::string& by = "") {
  return "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_plm=isolated OMPI_MCA_pml=ob1 "
         "OMPI_MCA_btl=self,vader " +
         by + " '" + dvdx::test::mpirun() + "' --oversubscribe -n " + std::to_string(ranks);
}

CommandResult run_on(int ranks, const ScratchFolder& folder, const std::string& arguments) {
  return run(folder, arguments, launcher(ranks));
}

// Runs that are much alike take turns: one on two ranks, neither of which is between others, and on five; the next on three.
std::vector<int> ranks_of(std::size_t turn) { return turn % 2 == 0 ? std::vector{2, 5} : std::vector{3}; }

// The part of a run's report that must not depend on the ranks.
nlohmann::json said(const CommandResult& result) {
  CHECK_MESSAGE(result.exit == 0, result.err);
  auto report = nlohmann::json::parse(result.out, nullptr, false);
  REQUIRE_FALSE(report.is_discarded());
  for (const char* key : {"wall_seconds", "particle_steps_per_second", "threads", "ranks", "halo"}) report.erase(key);
  // One process alone looks at lengths, and at what comes through cloth.
  for (const char* key : {"stretch", "rods"}) report.erase(key);
  for (const char* key : {"most", "given"}) report["energy"].erase(key);
  if (report.contains("meet")) report["meet"].erase("crossings");
  if (report.contains("warnings")) {
    auto& warnings = report["warnings"];
    for (std::size_t i = warnings.size(); i-- > 0;) {
      const auto& code = warnings[i]["code"];
      if (code == "pokes_through" || code == "crossed" || code == "may_cross") warnings.erase(i);
    }
  }
  // Files have the names that were asked for.
  if (report.contains("written")) {
    for (auto& file : report["written"]) file.erase("file");
  }
  return report;
}

std::size_t times(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++count;
  return count;
}

// Every value differs from particle to particle, and one of 53 is so fast that contacts take the formula for all.
std::string mixed() {
  nlohmann::json scene = nlohmann::json::parse(R"({
    "format": "dvdx-scene/1", "name": "mixed", "step": 0.02, "duration": 0.4,
    "particles": {"count": 53, "mass": {"uniform": {"min": 0.5, "max": 2, "seed": 4}},
                  "position": {"uniform": {"min": [0, 0.5, 0], "max": [1, 2, 1], "seed": 3}},
                  "velocity": {"file": "velocities.csv"}},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]},
               {"type": "drag", "coefficient": {"uniform": {"min": 0, "max": 0.5, "seed": 5}}, "wind": [1, 0, 0]},
               {"type": "spring", "stiffness": {"values": []}, "anchor": "start"}],
    "contacts": [{"type": "plane", "normal": [0, 1, 0.1], "offset": 0, "restitution": 0.7, "friction": 0.2},
                 {"type": "sphere", "center": [0.5, 0, 0.5], "radius": 0.5}],
    "fixed": [3, 17, 52]})");
  for (int i = 0; i < 53; ++i) scene["forces"][2]["stiffness"]["values"].push_back(i == 50 ? 30000.0 : i < 20 ? 0.0 : 5.0);
  return scene.dump();
}

// 9 rows of 7, hung up by two corners over a ball.
std::string sheet() {
  return R"({"format": "dvdx-scene/1", "name": "sheet", "step": 0.01, "duration": 0.05,
    "network": {"type": "grid", "rows": 9, "columns": 7, "origin": [0, 1, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0.3, 1], "mass": 0.2,
                "structural": 40, "shear": 20, "bend": 5, "fixed": ["corners_top"]},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}, {"type": "drag", "coefficient": 0.001}],
    "contacts": [{"type": "sphere", "center": [0.5, 0.9, 0.5], "radius": 0.2, "friction": 0.3}]})";
}

// Numbers as they come, two springs between two particles, and a particle that none holds.
std::string list() {
  return R"({"format": "dvdx-scene/1", "name": "list", "step": 0.01, "duration": 0.05,
    "particles": {"count": 12, "mass": {"uniform": {"min": 0.1, "max": 0.3, "seed": 4}},
                  "position": {"uniform": {"min": [0, 0, 0], "max": [1, 1, 1], "seed": 3}}},
    "network": [{"type": "springs", "pairs": [[0, 7], [7, 3], [3, 9], [9, 1], [1, 10], [10, 4], [4, 7], [3, 7]], "stiffness": 30,
                 "rest_length": 0.4, "damping": 0.02},
                {"type": "springs", "pairs": [[4, 8], [8, 2], [2, 5], [5, 0], [5, 11], [11, 0]], "stiffness": 30, "rest_length": "start"}],
    "fixed": [1], "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]})";
}

// Balls of two sizes in a hollow one over a floor that rises, one of them fixed: the first numbers are under the last, so that
// ranks' ranges meet.
std::string grains(int count = 41) {
  nlohmann::json scene = nlohmann::json::parse(R"({
    "format": "dvdx-scene/1", "name": "grains", "step": 0.0125, "duration": 0.5,
    "particles": {"mass": 0.02, "velocity": [0, -2, 0]},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "motions": {"lift": {"keys": [{"time": 0}, {"time": 1, "translation": [0, 0.2, 0]}]}},
    "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "friction": 0.5, "motion": "lift"},
                 {"type": "sphere", "center": [0, 0.4, 0], "radius": 0.41, "side": "inside", "restitution": 0.5}],
    "fixed": [0], "meet": {"friction": 0.4, "restitution": 0.5}})");
  auto& particles = scene["particles"];
  particles["count"] = count;
  for (int i = 0; i < count; ++i) {
    particles["position"]["values"].push_back(
        {0.09 * (i % 3 - 1) + 0.01 * (i / 3 % 2), 0.06 + 0.085 * (i / 9), 0.09 * (i / 3 % 3 - 1)});
    scene["meet"]["radius"]["values"].push_back(i % 4 == 1 ? 0.03 : 0.04);
  }
  return scene.dump();
}

// A sheet that is let go on edge, and folds on itself.
std::string folding() {
  return R"({"format": "dvdx-scene/1", "name": "folding", "step": 0.0166666666666666666, "duration": 0.4,
    "network": {"type": "grid", "rows": 24, "columns": 9, "origin": [0, 0.24, 0], "edge_u": [0.08, 0, 0], "edge_v": [0, -0.23, 0.02],
                "mass": 0.02, "structural": 60, "shear": 20, "bend": 2, "damping": 0.001, "scheme": "leapfrog"},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "friction": 0.5}],
    "meet": {"thickness": 0.0095, "friction": 0.3, "most_neighbours": 48}})";
}

// Drops of two emitters and three that were there, of which births in the middle of the run find no room.
std::string drops() {
  return R"({"format": "dvdx-scene/1", "name": "drops", "step": 0.0078125, "duration": 0.25, "capacity": 90,
    "particles": {"count": 3, "mass": 0.01, "position": {"uniform": {"min": [0, 0.1, 0], "max": [1, 2, 1], "seed": 3}}},
    "emitters": [{"type": "box", "min": [0, 0, 0], "max": [1, 0.05, 1], "rate": 700, "velocity": [0, -1, 0], "spread": 1,
                  "lifetime": {"min": 0.05, "max": 0.2}, "seed": 5},
                 {"type": "point", "at": [0, 0.5, 0], "rate": 90, "velocity": [1, 0, 0], "spread": [0.2, 0.2, 0], "seed": 6}],
    "removal": {"outside": {"min": [-1, -1, -1], "max": [1.05, 3, 2]}},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "restitution": 0.5, "friction": 0.2}]})";
}

class MixedFolder : public ScratchFolder {
 public:
  explicit MixedFolder(const std::string& name) : ScratchFolder("ranks-" + name) {
    write("mixed.json", mixed());
    std::string velocities = "x,y,z\n";
    for (int i = 0; i < 53; ++i) velocities += std::to_string(i % 7) + "," + std::to_string(-i % 5) + ",0.25\n";
    write("velocities.csv", velocities);
  }
};

const bool has_no_mpi = dvdx::test::mpirun().empty();

TEST_CASE("ranks: particles that nothing joins have the bits of one rank" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("bits");
  std::size_t turn = 0;
  for (const char* precision : {"float32", "float64", "float32_compensated"}) {
    const std::string arguments = std::string("run mixed.json --json --threads 1 --precision ") + precision;
    const auto alone = said(run(folder, arguments));
    for (const int ranks : ranks_of(turn++)) {
      CAPTURE(ranks);
      CHECK(said(run_on(ranks, folder, arguments)) == alone);
    }
  }
}

TEST_CASE("ranks: the number of ranks is said where a launcher started them, and by one of them" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("count");
  CHECK_FALSE(nlohmann::json::parse(run(folder, "run mixed.json --json").out).contains("ranks"));
  for (const int ranks : {1, 3}) {
    const auto result = run_on(ranks, folder, "run mixed.json --json --threads 2");
    REQUIRE(result.exit == 0);
    CHECK(nlohmann::json::parse(result.out).at("ranks") == ranks);
    CHECK(nlohmann::json::parse(result.out).at("particles") == 53);
    CHECK(result.err.empty());
  }
}

TEST_CASE("ranks: a command that does not share its work is refused once" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("one");
  for (const char* arguments : {"explain mixed.json", "report mixed.json", "verify mixed.json", "merge a.json"}) {
    const auto result = run_on(3, folder, arguments);
    CAPTURE(result.err);
    CHECK(result.exit == 2);
    CHECK(result.out.empty());
    const auto said = result.err.find(": started as 3 ranks: must be started as one");
    REQUIRE(said != std::string::npos);
    CHECK(result.err.find("must be started as one", said + 30) == std::string::npos);
  }
  CHECK(run_on(1, folder, "explain mixed.json").exit == 0);
}

TEST_CASE("ranks: of the shipped scenes all but some can be split") {
  std::vector<std::string> refused;
  std::size_t split = 0;
  for (const auto& entry : std::filesystem::directory_iterator(dvdx::test::scenes())) {
    if (entry.path().extension() != ".json") continue;
    try {
      dvdx::tool::check_can_be_split(dvdx::tool::read_scene(entry.path().string()), "");
      ++split;
    } catch (const dvdx::tool::Fault& fault) {
      CHECK(fault.exit() == dvdx::tool::Exit::bad_scene);
      refused.push_back(entry.path().stem().string());
    }
  }
  std::sort(refused.begin(), refused.end());
  // Grains that come and go, and what constraints join.
  CHECK(refused == std::vector<std::string>{"cradle", "pour", "ribbon", "towel"});
  CHECK(split >= 25);
}

TEST_CASE("ranks: more ranks than particles, and particles far from home" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-far");
  folder.write("far.json", R"({"format": "dvdx-scene/1", "name": "far", "step": 0.01, "duration": 0.1,
    "particles": {"count": 3, "position": {"values": [[0, 0, 0], [5000.25, 0, 0], [5000.25, 1, 0]]}, "velocity": [1, 2, 3]},
    "forces": [{"type": "spring", "stiffness": 2, "anchor": "start"}]})");
  for (const char* more : {"", " --set 'contacts=[{\"type\":\"plane\",\"normal\":[0,1,0],\"offset\":-1}]'"}) {
    const std::string arguments = std::string("run far.json --json --threads 1") + more;
    CHECK(said(run_on(5, folder, arguments)) == said(run(folder, arguments)));
  }
}

TEST_CASE("ranks: networks have the bits of one rank" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-networks");
  folder.write("sheet.json", sheet());
  folder.write("list.json", list());
  auto skin = nlohmann::json::parse(sheet());
  skin["skins"] = {{{"particles", {30, 31, 32, 44, 45}}, {"at_most", 0.01}}};
  folder.write("skin.json", skin.dump());
  std::size_t turn = 0;
  for (const char* run_of :
       {"sheet.json", "sheet.json --set network.bend=0 --set network.damping=0.01 --precision float64", "list.json",
        "list.json --scheme fourth_order --precision float32_compensated", "sheet.json --scheme accumulate", "skin.json"}) {
    CAPTURE(run_of);
    const std::string arguments = std::string("run ") + run_of + " --json --threads 1";
    const auto alone = said(run(folder, arguments));
    for (const int ranks : ranks_of(turn++)) {
      CAPTURE(ranks);
      CHECK(said(run_on(ranks, folder, arguments)) == alone);
    }
  }
}

// Which sub-steps it takes, and whether it heats, is found without a plan of the whole, but for what lies between bounds.
TEST_CASE("ranks: a sheet that no rank plans whole has the bits, the words and the refusals of one rank" *
          doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-rows");
  auto scene = nlohmann::json::parse(sheet());
  scene["network"]["rows"] = 70;
  scene["network"]["edge_v"] = {0, 3, 10};
  scene["duration"] = 0.8;
  scene["particles"] = {{"velocity", {{"uniform", {{"min", {-9, -9, -9}}, {"max", {9, 9, 9}}, {"seed", 3}}}}}};
  folder.write("sheet.json", scene.dump());
  std::size_t turn = 0;
  for (const char* more :
       {"", " --scheme fourth_order --threads 2", " --set network.scheme=sequential --set network.lines=none",
        " --substeps 12 --precision float64", " --precision float32_compensated"}) {
    CAPTURE(more);
    const std::string arguments = std::string("run sheet.json --json") + more;
    const auto alone = said(run(folder, arguments));
    for (const int ranks : ranks_of(turn++)) CHECK(said(run_on(ranks, folder, arguments)) == alone);
  }
  for (const char* more :
       {" --substeps 1 --set network.structural=4000", " --set network.mass=1e-300", " --set particles.velocity=[1e300,0,0]"}) {
    CAPTURE(more);
    const std::string arguments = std::string("run sheet.json --json") + more;
    const auto alone = run(folder, arguments);
    const auto split = run_on(3, folder, arguments);
    CHECK(alone.exit != 0);
    CHECK(split.exit == alone.exit);
    CHECK(split.err.find(alone.err) != std::string::npos);
  }
}

// The owners look for springs that tear. The number of sub-steps may then fall for all ranks.
TEST_CASE("ranks: what tears has the bits, the files and the checkpoints of one rank" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-torn");
  folder.write("playback.html", "<!-- dvdx data -->");
  const std::string viewer = "DVDX_VIEWER=.";
  auto scene = nlohmann::json::parse(sheet());
  scene["network"]["tears_at"] = 1.02;
  scene["network"]["structural"] = 20;
  scene["duration"] = 0.4;
  folder.write("sheet.json", scene.dump());
  scene["network"]["scheme"] = "sequential";
  scene["network"]["lines"] = "none";
  scene["network"]["rows"] = 100;
  scene["network"]["edge_v"] = {0, 3, 10};
  scene["network"]["tears_at"] = 1.03;
  folder.write("swept.json", scene.dump());
  auto springs = nlohmann::json::parse(list());
  springs["network"][0]["tears_at"] = 1.2;
  springs["network"][1]["tears_at"] = 1.01;
  springs["duration"] = 0.4;
  folder.write("list.json", springs.dump());
  for (const auto& of : {std::pair("sheet.json", 2), std::pair("sheet.json --precision float64", 5), std::pair("swept.json", 2),
                         std::pair("list.json --scheme fourth_order", 3)}) {
    const char* const run_of = of.first;
    const int ranks = of.second;
    CAPTURE(run_of);
    const std::string arguments = std::string("run ") + run_of + " --json --every 7 --threads 1 --out ";
    const auto alone = said(run(folder, arguments + "whole.html", viewer));
    CHECK(alone["torn"] > 5);
    for (const char* more : {" --checkpoint at --checkpoint-every 13", " --resume at"}) {
      auto report = said(run(folder, arguments + "a.html" + more, launcher(ranks, viewer)));
      report.erase("resumed_at_step");
      CHECK(report == alone);
      CHECK(folder.read("a.html") == folder.read("whole.html"));
    }
  }
}

// The line of `explain --ranks` that counts what all ranks tell in a sub-step: bytes and messages of the way that tells least.
std::array<std::uint64_t, 2> predicted(const ScratchFolder& folder, const std::string& scene, int ranks) {
  const auto told = run(folder, "explain " + scene + " --particle-time 1e-9 --ranks " + std::to_string(ranks));
  REQUIRE_MESSAGE(told.exit == 0, told.err);
  std::array<std::uint64_t, 2> least{~std::uint64_t{0}, 0};
  const std::string before = "to a rank at most; ";
  for (auto at = told.out.find(before); at != std::string::npos; at = told.out.find(before, at + 1)) {
    std::array<std::uint64_t, 2> some{};
    REQUIRE(std::sscanf(told.out.c_str() + at + before.size(), "%lu bytes in %lu over all ranks", &some[0], &some[1]) == 2);
    least = std::min(least, some);
  }
  return least;
}

TEST_CASE("ranks: what a run tells is what explain counts, byte for byte" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-told");
  folder.write("sheet.json", sheet());
  folder.write("list.json", list());
  for (const char* scene : {"sheet.json", "sheet.json --set network.damping=0.01 --precision float64", "list.json",
                            "sheet.json --set network.scheme=accumulate", "list.json --scheme accumulate"}) {
    CAPTURE(scene);
    const auto result = run_on(3, folder, std::string("run ") + scene + " --json --threads 1");
    REQUIRE_MESSAGE(result.exit == 0, result.err);
    const auto report = nlohmann::json::parse(result.out);
    const auto [bytes, messages] = predicted(folder, scene, 3);
    const auto substeps = report["steps"].get<std::uint64_t>() * report["substeps"].get<std::uint64_t>();
    CHECK(messages > 0);
    CHECK(report["halo"]["bytes"] == substeps * bytes);
    CHECK(report["halo"]["messages"] == substeps * messages);
  }
}

TEST_CASE("ranks: particles that meet have the bits and impacts of one rank, and tell what explain counts" *
          doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-meet");
  folder.write("grains.json", grains());
  folder.write("folding.json", folding());
  std::size_t turn = 0;
  for (const std::string& scene :
       {std::string("grains.json"), std::string("folding.json"), std::string("grains.json --precision float32_compensated"),
        "'" + dvdx::test::scenes() + "/heap.json' --duration 0.2 --precision float64",
        "'" + dvdx::test::scenes() + "/layers.json' --duration 0.25 --set network[0].lines=none --set network[1].lines=none"}) {
    CAPTURE(scene);
    const std::string arguments = "run " + scene + " --json --every 7 --threads 1";
    const auto alone = said(run(folder, arguments + " --out a.csv --events a-events.csv"));
    CHECK(alone["meet"]["pairs"] > 0);
    CHECK(alone["meet"]["overlap"]["most"] > 0);
    for (const int ranks : ranks_of(turn++)) {
      CAPTURE(ranks);
      const auto result = run_on(ranks, folder, arguments + " --out b.csv --events b-events.csv");
      CHECK(said(result) == alone);
      CHECK(folder.read("b.csv") == folder.read("a.csv"));
      CHECK(folder.read("b-events.csv") == folder.read("a-events.csv"));
      if (scene.find("layers") != std::string::npos) continue;  // more ranks than sheets
      const auto report = nlohmann::json::parse(result.out);
      const auto [bytes, messages] = predicted(folder, scene, ranks);
      const auto substeps = report["steps"].get<std::uint64_t>() * report["substeps"].get<std::uint64_t>();
      CHECK(report["halo"]["bytes"] == substeps * bytes);
      CHECK(report["halo"]["messages"] == substeps * messages);
    }
  }
}

TEST_CASE("ranks: of particles that meet some ranks have none, and too many neighbours end all at once" *
          doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-crowd");
  folder.write("few.json", grains(3));
  const std::string arguments = "run few.json --json --threads 1";
  CHECK(said(run_on(5, folder, arguments)) == said(run(folder, arguments)));
  folder.write("grains.json", grains());
  const auto refused = run_on(3, folder, "run grains.json --set meet.most_neighbours=2 --out a.csv");
  CHECK(refused.exit == 3);
  CHECK_MESSAGE(times(refused.err, "meet.most_neighbours is 2, and between") == 1, refused.err);
  CHECK_FALSE(std::filesystem::exists(folder / "a.csv"));
}

// A band of a sheet 7 wide has 32 rows, and a rank has two bands: some of these ranks have nothing.
TEST_CASE("ranks: networks that are swept have the bits of one rank, and tell what explain counts" *
          doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-swept");
  auto scene = nlohmann::json::parse(sheet());
  scene["network"]["rows"] = 150;
  scene["network"]["edge_v"] = {0, 3, 10};
  scene["network"]["scheme"] = "sequential";
  scene["network"]["lines"] = "none";
  scene["network"]["substeps"] = 3;
  scene["duration"] = 0.2;
  folder.write("sheet.json", scene.dump());
  scene["network"]["bend"] = 0;
  scene["network"]["aerodynamics"] = {{"density", 1.2}, {"drag", 1.0}, {"lift", 0.5}};
  folder.write("flag.json", scene.dump());
  auto list = nlohmann::json::parse(sheet());
  list["network"]["rows"] = list["network"]["columns"] = 70;  // two pieces
  list["network"]["scheme"] = "sequential";
  list["network"]["lines"] = "none";
  list["network"]["substeps"] = 2;
  nlohmann::json more{{"type", "springs"}, {"pairs", {{0, 4000}, {3, 9}}}, {"stiffness", 5}, {"rest_length", "start"}};
  more["scheme"] = "sequential";
  more["lines"] = "none";
  more["substeps"] = 2;
  list["network"] = {list["network"], more};
  folder.write("list.json", list.dump());
  auto in_rows = list;  // of two networks, which sweeps walk as one sheet
  in_rows["network"][0]["rows"] = 150;
  in_rows["network"][0]["columns"] = 20;
  in_rows["network"][0]["shear"] = in_rows["network"][0]["bend"] = 0;
  in_rows["network"][1]["pairs"] = {{0, 21}, {22, 43}, {1203, 1222}, {2959, 2978}};
  folder.write("in_rows.json", in_rows.dump());
  auto three = nlohmann::json::parse(sheet());
  three["network"]["scheme"] = "sequential";
  three["network"]["lines"] = "none";
  three["network"] = {three["network"], three["network"], three["network"]};
  folder.write("three.json", three.dump());
  std::size_t turn = 0;
  for (const char* run_of : {"three.json", "sheet.json --set network.damping=0.01 --precision float64",
                             "sheet.json --set network.theta=0.6 --precision float32_compensated",
                             "list.json --precision float32_compensated", "flag.json"}) {
    CAPTURE(run_of);
    const std::string arguments = std::string("run ") + run_of + " --json --threads 1";
    const auto alone = said(run(folder, arguments));
    for (const int ranks : ranks_of(turn++)) {
      CAPTURE(ranks);
      CHECK(said(run_on(ranks, folder, arguments)) == alone);
    }
  }
  for (const std::string name : {"sheet.json", "list.json", "in_rows.json"}) {
    const std::string arguments = "run " + name + " --json --threads 1";
    const auto alone = said(run(folder, arguments));
    for (const int ranks : {2, 5}) {
      CAPTURE(name);
      CAPTURE(ranks);
      const auto result = run_on(ranks, folder, arguments);
      CHECK(said(result) == alone);
      const auto report = nlohmann::json::parse(result.out);
      const auto [bytes, messages] = predicted(folder, name, ranks);
      const auto substeps = report["steps"].get<std::uint64_t>() * report["substeps"].get<std::uint64_t>();
      if (name != "list.json") CHECK(messages == (ranks == 2 ? 2 : name == "sheet.json" ? 4 : 6));
      CHECK(messages > 0);
      CHECK(report["halo"]["bytes"] == substeps * bytes);
      CHECK(report["halo"]["messages"] == substeps * messages);
    }
  }
}

// The list's numbers are scattered over its ranks, and no rank shows what it steps. Drops begin with fewer than there are ranks.
TEST_CASE("ranks: every file has the bytes of one rank's" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("files");
  folder.write("list.json", list());
  folder.write("drops.json", drops());
  folder.write("playback.html", "<!-- dvdx data -->");
  const std::string viewer = "DVDX_VIEWER=.";
  const std::vector<std::string> kinds{"csv", "npz", "ply", "pc2", "vtp"};
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& kind : kinds) files.emplace_back("mixed", kind);
  for (const auto& kind : kinds) files.emplace_back("list", kind);
  files.emplace_back("list", "html");
  for (const char* kind : {"csv", "ply", "vtp", "html"}) files.emplace_back("drops", kind);
  for (const auto& of : files) {
    const std::string &scene = of.first, &kind = of.second;
    CAPTURE(scene);
    CAPTURE(kind);
    const std::string arguments = "run " + scene + ".json --every 2 --out ";
    const std::string alone = scene + "-" + kind;
    std::filesystem::create_directory(folder / alone);
    REQUIRE(run(folder, arguments + alone + "/all." + kind, viewer).exit == 0);
    const ScratchFolder parts("ranks-parts");
    const auto result = run(folder, arguments + (parts / "all.") + kind,
                            launcher(scene == "drops" ? 5
                                     : kind == "csv"  ? 2
                                                      : 3,
                                     viewer));
    CHECK_MESSAGE(result.exit == 0, result.err);
    CHECK(parts.entries() > 0);
    for (const auto& entry : std::filesystem::directory_iterator(folder / alone)) {
      const auto name = entry.path().filename().string();
      CHECK(folder.read(alone + "/" + name) == parts.read(name));
    }
  }
}

TEST_CASE("ranks: what ends one ends all, says so once and leaves nothing" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("faults");
  const auto before = folder.entries();
  const auto check = [&](const std::string& arguments, int exit, const std::string& message) {
    CAPTURE(arguments);
    const auto result = run_on(3, folder, "run mixed.json " + arguments);
    CHECK(result.exit == exit);
    CHECK_MESSAGE(times(result.err, message) == 1, result.err);
    CHECK(result.out.empty());
    CHECK(folder.entries() == before);
  };
  check("--set step=-1", 3, "step is -1");
  // Only the last rank has this particle.
  check(
      "--set particles.position='{\"values\":[" +
          [] {
            std::string list;
            for (int i = 0; i < 52; ++i) list += "[0,1,0],";
            return list;
          }() +
          "[1e300,1,0]]}'",
      3, "particle 52");
  check("--out nowhere/all.csv", 4, "there is no directory nowhere");
  check("--out all.html", 2, "a page is not written by several ranks");
  check(
      "--set 'network={\"type\":\"springs\",\"pairs\":[[0,1]],\"stiffness\":1,\"rest_length\":1,\"tears_at\":2,"
      "\"scheme\":\"sequential\",\"lines\":\"none\"}'",
      3, "network.tears_at by scheme sequential cannot be split over ranks");
  check("--set 'network={\"type\":\"springs\",\"pairs\":[[0,1]],\"stiffness\":1,\"rest_length\":1,\"scheme\":\"sequential\"}'",
        3, "network.lines is rows");
  check("--set 'constraints=[{\"type\":\"distance\",\"pairs\":[[0,1]],\"length\":1}]'", 3, "constraints cannot be split");
}

TEST_CASE("ranks: cloth in wind has the bits of one rank, as a sheet and as a list" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-air");
  auto scene = nlohmann::json::parse(sheet());
  scene["network"]["bend"] = 0;
  scene["network"]["aerodynamics"] = {{"density", 1.2}, {"drag", 1.0}, {"lift", 0.5}};
  scene["wind"] = {{"mean", {9, 1, 3}}, {"gusts", {{{"amplitude", {2, 0, 5}}, {"angular_frequency", 40}}}}};
  folder.write("sheet.json", scene.dump());
  scene["network"]["damping"] = 0.01;
  const nlohmann::json one_more{{"type", "springs"}, {"pairs", {{0, 10}}}, {"stiffness", 5}, {"rest_length", "start"}};
  scene["network"] = {scene["network"], one_more};  // with which the sheet is stepped as a list
  folder.write("list.json", scene.dump());
  for (const char* run_of : {"sheet.json", "list.json --scheme fourth_order --precision float64"}) {
    CAPTURE(run_of);
    const std::string arguments = std::string("run ") + run_of + " --json --threads 1";
    const auto alone = said(run(folder, arguments));
    for (const int ranks : {2, 5}) {
      CAPTURE(ranks);
      CHECK(said(run_on(ranks, folder, arguments)) == alone);
    }
  }
}

// A run in three ways: never stopped, with checkpoints, and gone on from the last of them.
TEST_CASE("ranks: what others wrote down goes on to the same bits, files, impacts and sums" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("resumed");
  folder.write("sheet.json", sheet());
  auto swept = nlohmann::json::parse(sheet());
  swept["network"]["rows"] = 200;
  swept["network"]["scheme"] = "sequential";
  swept["network"]["lines"] = "none";
  swept["duration"] = 0.2;
  folder.write("swept.json", swept.dump());
  folder.write("grains.json", grains());
  struct Case {
    std::string run;
    int first, second;
  };
  for (const Case& of : {Case{"mixed.json", 3, 2}, Case{"mixed.json --precision float32_compensated", 1, 3},
                         Case{"swept.json", 3, 2}, Case{"grains.json", 3, 2}, Case{"sheet.json --duration 0.2", 3, 2},
                         Case{"sheet.json --duration 0.2 --precision float32_compensated", 1, 2}}) {
    CAPTURE(of.run);
    const std::string arguments = "run " + of.run + " --json --every 3 --threads ";
    auto whole = said(run(folder, arguments + "1 --out whole.csv --events whole-events.csv"));
    if (whole.contains("meet")) whole["meet"].erase("rebuilt");  // who goes on begins with new lists
    CHECK(folder.read("whole-events.csv").size() > 100);
    const auto check = [&](int ranks, const std::string& more) {
      const auto result = run_on(ranks, folder, arguments + "2 --out a.csv --events e.csv " + more);
      auto report = said(result);
      report.erase("resumed_at_step");
      if (report.contains("meet")) report["meet"].erase("rebuilt");
      CHECK(report == whole);
      CHECK(folder.read("a.csv") == folder.read("whole.csv"));
      CHECK(folder.read("e.csv") == folder.read("whole-events.csv"));
    };
    check(of.first, "--checkpoint at --checkpoint-every 11");
    check(of.second, "--resume at --checkpoint again --checkpoint-every 6");
  }
}

TEST_CASE("ranks: a checkpoint has the bytes of one rank's, and of a damaged one all are told once" *
          doctest::skip(has_no_mpi)) {
  const MixedFolder folder("checkpoint");
  const std::string arguments = "run mixed.json --every 4 --out a.csv --checkpoint at --checkpoint-every 13";
  // The head and the columns: what contacts have done may be other words for the same sums, and the end says how long it took.
  const auto written = [&] {
    const auto bytes = folder.read("at");
    REQUIRE(bytes.size() > 1400);
    return bytes.substr(0, 1400) + folder.read("at.states");
  };
  REQUIRE(run(folder, arguments).exit == 0);
  const auto alone = written();
  std::filesystem::remove(folder / "at");
  const auto result = run_on(3, folder, arguments);
  REQUIRE_MESSAGE(result.exit == 0, result.err);
  CHECK(written() == alone);
  auto bytes = folder.read("at");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  folder.write("at", bytes);
  const auto refused = run_on(3, folder, "run mixed.json --resume at");
  CHECK(refused.exit == 4);
  CHECK(times(refused.err, "at: is damaged") == 1);
}

// A page knows particles by their ids, which a checkpoint keeps.
TEST_CASE("ranks: particles that come and go have the bits, files, pages and impacts of one rank" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-live");
  folder.write("drops.json", drops());
  folder.write("playback.html", "<!-- dvdx data -->");
  const std::string viewer = "DVDX_VIEWER=.";
  for (const char* run_of : {"drops.json", "drops.json --precision float64 --layout aosoa"}) {
    CAPTURE(run_of);
    const std::string arguments = std::string("run ") + run_of + " --json --every 5 ";
    const auto alone = said(run(folder, arguments + "--threads 1 --out whole.html --events impacts.csv", viewer));
    CHECK(alone["dropped"] > 0);
    CHECK(alone["removed"] > 50);
    CHECK(folder.read("impacts.csv").size() > 1000);
    for (const int ranks : run_of == std::string("drops.json") ? std::vector{2, 3, 5} : std::vector{2}) {
      CAPTURE(ranks);
      const std::string more = ranks == 2 ? "--checkpoint at --checkpoint-every 7" : ranks == 3 ? "--resume at" : "";
      auto report = said(run(folder, arguments + "--threads 2 --out a.html --events e.csv " + more, launcher(ranks, viewer)));
      report.erase("resumed_at_step");
      CHECK(report == alone);
      CHECK(folder.read("a.html") == folder.read("whole.html"));
      CHECK(folder.read("e.csv") == folder.read("impacts.csv"));
    }
  }
  const auto refused = run_on(2, folder, "run drops.json --set removal.order=any");
  CHECK(refused.exit == 3);
  CHECK(times(refused.err, "removal.order any, by which a hole may be filled from another rank, cannot be split") == 1);
}

// Up to what the contacts' sums follow, and of what comes and goes up to its ids.
TEST_CASE("ranks: a checkpoint of what comes and goes has the bytes of one rank's" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-live-checkpoint");
  folder.write("drops.json", drops());
  const std::string arguments = "run drops.json --every 5 --out a.csv --checkpoint at --checkpoint-every 29";
  const auto number_at = [](const std::string& bytes, std::size_t place, std::size_t size) {
    std::uint64_t number = 0;
    std::memcpy(&number, bytes.data() + place, size);
    return number;
  };
  const auto written = [&](const CommandResult& result) {
    REQUIRE_MESSAGE(result.exit == 0, result.err);
    const auto bytes = folder.read("at");
    const std::size_t data = 28 + number_at(bytes, 20, 4);
    std::filesystem::remove(folder / "at");  // which would have the next one's states beside it take another name
    const std::uint64_t particles = number_at(bytes, data, 8);
    CHECK(particles > 40);
    const std::size_t ids = data + 24 + particles * 8 * sizeof(float) + 3 * 8;
    CHECK(number_at(bytes, ids, 8) == particles);
    return bytes.substr(0, ids + 8 + particles * 4 + 4) + folder.read("at.states");
  };
  const auto alone = written(run(folder, arguments));
  for (const int ranks : {2, 5}) CHECK(written(run_on(ranks, folder, arguments)) == alone);
}

// Bytes, of each of eight ranks: each process writes down the most memory that it has taken.
std::vector<double> most_memory(const ScratchFolder& folder, const nlohmann::json& scene, const std::string& more) {
  folder.write("many.json", scene.dump());
  folder.write("most.sh", R"("$@" & process=$!
file=most.$OMPI_COMM_WORLD_RANK
while grep VmHWM /proc/$process/status > $file.now 2> $file.ended; do
  mv $file.now $file
  sleep 0.01
done
wait $process)");
  const auto result = run(folder, "run many.json --threads 1" + more, launcher(8) + " sh most.sh");
  REQUIRE_MESSAGE(result.exit == 0, result.err);
  std::vector<double> bytes;
  for (int rank = 0; rank < 8; ++rank) {
    const auto text = folder.read("most." + std::to_string(rank));
    bytes.push_back(1024 * std::stod(text.substr(text.find(':') + 1)));
  }
  return bytes;
}

TEST_CASE("ranks: no rank holds all particles that come and go" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-live-memory");
  constexpr std::size_t particles = 500'000;
  const auto of = [&](std::size_t capacity) {
    auto scene = nlohmann::json::parse(drops());
    scene["capacity"] = capacity;
    scene["particles"]["count"] = capacity - 10;
    scene["duration"] = 3 * scene["step"].get<double>();
    return most_memory(folder, scene, " --every 2 --out a.vtp --checkpoint at --checkpoint-every 2");
  };
  const auto few = of(100), many = of(particles);
  for (std::size_t rank = 0; rank < few.size(); ++rank) {
    CAPTURE(rank);
    CHECK(many[rank] - few[rank] < 8 * sizeof(float) * particles);
  }
}

// Held whole, places would take 24 bytes a particle and faces 64, and both twice while they are read. A rank holds an eighth of the
// rows and those that its own wait for, and a plan's columns for these.
TEST_CASE("ranks: no rank holds a sheet whole" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-sheet-memory");
  constexpr std::size_t rows = 512, columns = 512;
  const auto of = [&](std::size_t more_rows) {
    auto scene = nlohmann::json::parse(sheet());
    auto& network = scene["network"];
    network["rows"] = more_rows;
    network["columns"] = columns;
    network["edge_v"] = {0, 0, 0.002 * static_cast<double>(more_rows)};
    network["mass"] = 1e-6 * static_cast<double>(more_rows * columns);
    scene["step"] = 0.001;
    scene["duration"] = 2 * scene["step"].get<double>();
    return most_memory(folder, scene, " --json");
  };
  const auto few = of(64), many = of(rows);
  for (std::size_t rank = 0; rank < few.size(); ++rank) {
    CAPTURE(rank);
    CHECK(many[rank] - few[rank] < 48 * (rows - 64) * columns);
  }
}

// A command asks no plan of a sheet for them; a plan looks at its springs, and at what turns.
TEST_CASE("the sub-steps of a sheet that a run finds by rows are its plan's") {
  const ScratchFolder folder("sheet-substeps");
  auto scene = nlohmann::json::parse(sheet());
  scene["motions"]["spin"]["keys"] = {{{"time", 0}}, {{"time", 0.01}, {"rotation", {0, 3, 0}}}};
  std::vector<int> found;
  for (const bool turns : {false, true}) {
    if (turns) scene["contacts"][0]["motion"] = "spin";
    for (const char* scheme : {"leapfrog", "fourth_order", "sequential"}) {
      CAPTURE(turns);
      CAPTURE(scheme);
      scene["network"]["scheme"] = scheme;
      const std::string text = scene.dump();
      folder.write("sheet.json", text);
      const auto file = dvdx::tool::parse_scene("sheet.json", text);
      dvdx::Soa<float> memory(file.particles.count);
      auto state = memory.view();
      dvdx::tool::place_at_start(file, state);
      const auto plan = dvdx::compile<float>(file.scene, {.step = file.step}, state);
      REQUIRE_MESSAGE(plan.has_value(), (plan ? "" : plan.error().message()));
      found.push_back(plan->network_limit()->substeps);
      CHECK(said(run(folder, "run sheet.json --json"))["substeps"] == found.back());
    }
  }
  CHECK(found[0] > 1);
  CHECK(found[5] > found[2]);
}

TEST_CASE("ranks: explain tells how births are shared, and refuses what they have none of") {
  const ScratchFolder folder("ranks-births");
  folder.write("drops.json", drops());
  const auto told = run(folder, "explain drops.json --ranks 4 --particle-time 1e-6 --latency 1e-6");
  REQUIRE_MESSAGE(told.exit == 0, told.err);
  CHECK(told.out.find("6.172, of which a rank makes 1.543\n") != std::string::npos);  // (700 + 90) / 128
  CHECK(told.out.find("about 22.5 when all 90 live") != std::string::npos);
  CHECK(told.out.find("2.275e-05 s: 2.25e-05 s of particles, 2.5e-07 s of sums") != std::string::npos);
  CHECK(run(folder, "explain drops.json --ranks 4 --size 1e9").exit == 2);
  CHECK(run(folder, "explain drops.json --ranks 4 --set removal.order=any").exit == 3);
}

TEST_CASE("ranks: a piece each, and an index that names them" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("pieces");
  const auto corners = [&](const std::string& file) {
    pugi::xml_document piece;
    REQUIRE(piece.load_file((folder / file).c_str()));
    return piece.child("VTKFile").child("PolyData").child("Piece").attribute("NumberOfPoints").as_int();
  };
  for (const int ranks : {3, 1}) {
    const auto result = run_on(ranks, folder, "run mixed.json --every 10 --out all.pvtp");
    REQUIRE_MESSAGE(result.exit == 0, result.err);
    for (const char* index : {"all.pvtp", "all-000000.pvtp", "all-000001.pvtp", "all-000002.pvtp"}) {
      pugi::xml_document document;
      REQUIRE(document.load_file((folder / index).c_str()));
      const auto data = document.child("VTKFile").child("PPolyData");
      CHECK(std::string(data.child("PPoints").child("PDataArray").attribute("Name").value()) == "position");
      CHECK(std::string(data.child("PPointData").child("PDataArray").attribute("type").value()) == "Float32");
      int particles = 0;
      int pieces = 0;
      for (const auto& piece : data.children("Piece")) {
        ++pieces;
        particles += corners(piece.attribute("Source").value());
      }
      CHECK(pieces == ranks);
      CHECK(particles == 53);
    }
    CHECK(times(folder.read("all.pvd"), ".pvtp") == 3);
    // No pieces of more ranks are left.
    CHECK(std::filesystem::exists(folder / "all-000002-0002.vtp") == (ranks == 3));
  }
}

// A sheet of which springs join all rows, and particles that come and go.
TEST_CASE("ranks: what stands in a piece for each, of a network and of what comes and goes" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("gathered-pieces");
  folder.write("sheet.json", sheet());
  folder.write("drops.json", drops());
  for (const auto& of : {std::pair(std::string("sheet"), 2 * 7), std::pair(std::string("drops"), 0)}) {
    const std::string& scene = of.first;
    const int ghosts = of.second;
    CAPTURE(scene);
    const auto numbers = [&](const std::string& file, const char* attribute) {
      pugi::xml_document piece;
      REQUIRE(piece.load_file((folder / file).c_str()));
      return piece.child("VTKFile").child("PolyData").child("Piece").attribute(attribute).as_int();
    };
    const auto last = scene + "-000001";
    const std::string command = "run " + scene + ".json --every 100 --out " + scene;
    for (const auto& [ranks, more] : {std::pair(1, ".vtp"), std::pair(3, ".pvtp --checkpoint at --checkpoint-every 3")}) {
      const auto result = run_on(ranks, folder, command + more);
      REQUIRE_MESSAGE(result.exit == 0, result.err);
    }
    int points = 0;
    int faces = 0;
    for (const char* piece : {"-0000.vtp", "-0001.vtp", "-0002.vtp"}) {
      CHECK(numbers(last + piece, "NumberOfPoints") > 7);
      points += numbers(last + piece, "NumberOfPoints");
      faces += numbers(last + piece, "NumberOfPolys");
    }
    CHECK(points == numbers(last + ".vtp", "NumberOfPoints") + ghosts);
    CHECK(faces == numbers(last + ".vtp", "NumberOfPolys"));
    CHECK(times(folder.read(scene + ".pvtp"), "<Piece ") == 3);
    CHECK(times(folder.read(scene + ".pvtp"), "vtkGhostType") == (ghosts > 0 ? 1 : 0));
  }
}

// Two strips of squares whose common side is twice in the file, behind a vertex that no face uses.
TEST_CASE("ranks: a welded mesh is written by its file's vertices, as by one" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("welded");
  std::string mesh = "v 9 9 9\n";
  std::string faces;
  for (int strip = 0; strip < 2; ++strip) {
    const int first = 2 + 40 * strip;
    for (int n = 0; n < 20; ++n) {
      for (int side = 0; side < 2; ++side) mesh += "v " + std::to_string(n) + " 0 " + std::to_string(strip + side) + "\n";
      const int at = first + 2 * n;
      if (n > 0)
        faces += "f " + std::to_string(at - 2) + " " + std::to_string(at) + " " + std::to_string(at + 1) + " " +
                 std::to_string(at - 1) + "\n";
    }
  }
  folder.write("strips.obj", mesh + faces);
  folder.write("strips.json", R"({"format": "dvdx-scene/1", "name": "strips", "step": 0.01, "duration": 0.2,
    "network": {"type": "mesh", "file": "strips.obj", "mass": 6, "edge": 100, "bend": 1, "fixed": [1, 2, 42]},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]})");
  const auto one = run(folder, "run strips.json --every 10 --out one.csv --json");
  REQUIRE_MESSAGE(one.exit == 0, one.err);
  CHECK(nlohmann::json::parse(one.out)["particles"] == 60);
  for (const char* more : {"three.csv", "three.pvtp"}) {
    const auto three = run_on(3, folder, std::string("run strips.json --every 10 --json --out ") + more);
    REQUIRE_MESSAGE(three.exit == 0, three.err);
    CHECK(nlohmann::json::parse(three.out)["state_hash"] == nlohmann::json::parse(one.out)["state_hash"]);
  }
  CHECK(folder.read("three.csv") == folder.read("one.csv"));
  pugi::xml_document piece;
  REQUIRE(piece.load_file((folder / "three-000002-0000.vtp").c_str()));
  CHECK(piece.child("VTKFile").child("PolyData").child("Piece").attribute("NumberOfPoints").as_int() == 81);
}

TEST_CASE("ranks: one that is killed ends the others, nothing is half written, and the run goes on" *
          doctest::skip(has_no_mpi)) {
  const MixedFolder folder("killed");
  const std::string what = "run mixed.json --duration 4000 --every 50000 --json --threads 1 ";
  const auto whole = said(run(folder, what + "--out whole.csv"));
  const auto start = std::chrono::steady_clock::now();
  // Once there is a checkpoint one rank is killed: the launcher is their parent.
  folder.write("kill.sh", R"("$@" & launcher=$!
for n in $(seq 300); do
  [ -e at ] && break
  sleep 0.1
done
ranks=$(pgrep -P $launcher -x dvdx)
kill -9 ${ranks##* }
wait $launcher)");
  const auto killed = run(folder, what + "--out all.csv --checkpoint at --checkpoint-every 5000", launcher(3, "sh kill.sh"));
  CHECK(killed.exit != 0);
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(60));
  CHECK_FALSE(std::filesystem::exists(folder / "all.csv"));
  auto report = said(run_on(2, folder, what + "--out all.csv --resume at"));
  CHECK(report.contains("resumed_at_step"));
  report.erase("resumed_at_step");
  CHECK(report == whole);
  CHECK(folder.read("all.csv") == folder.read("whole.csv"));
}

}  // namespace ranks_test
