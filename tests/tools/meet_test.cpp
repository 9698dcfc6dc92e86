// Particles that meet, through the command: a run's messages about them, its stops, and its warnings.
#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "output/html_scene.hpp"
#include "scene_io/scene_reader.hpp"
#include "support/close.hpp"
#include "support/paths.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace meet_test {

using dvdx::test::is_close;
using dvdx::test::run;
using dvdx::test::ScratchFolder;
using nlohmann::json;

// 64 balls, 4 by 4 in a layer and almost touching, fall into a box that they fill.
void write_grains(const ScratchFolder& folder) {
  folder.write("grains.json", R"({"format": "dvdx-scene/1", "name": "grains", "step": 0.01, "duration": 0.3,
    "particles": {"count": 64, "mass": 0.1,
      "position": {"lattice": {"min": [0, 0.1, 0], "max": [0.34, 1, 0.34], "spacing": 0.11, "jitter": 0.004, "seed": 1}}},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0},
      {"type": "plane", "normal": [1, 0, 0], "offset": -0.06}, {"type": "plane", "normal": [-1, 0, 0], "offset": -0.4},
      {"type": "plane", "normal": [0, 0, 1], "offset": -0.06}, {"type": "plane", "normal": [0, 0, -1], "offset": -0.4}],
    "meet": {"radius": 0.05, "friction": 0.3}})");
}

// 6 x 6 at 1 cm, hung up by two corners.
void write_sheet(const ScratchFolder& folder, const std::string& structural) {
  folder.write("sheet.json", R"({"format": "dvdx-scene/1", "name": "sheet", "step": 0.01, "duration": 0.2,
    "network": {"type": "grid", "rows": 6, "columns": 6, "origin": [0, 0, 0], "edge_u": [0.05, 0, 0], "edge_v": [0, -0.05, 0],
      "mass": 0.36, "damping": 0.01, "fixed": "edge_top", "structural": )" +
                                 structural + R"(},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "meet": {"thickness": 0.008}})");
}

std::string cure_of(const json& report) {
  REQUIRE(report["warnings"].size() == 1);
  return report["warnings"][0]["cure"].get<std::string>();
}

TEST_CASE("run reports how many pairs touch, and how long the neighbour lists were") {
  const ScratchFolder folder("meet-run");
  write_grains(folder);
  const auto result = run(folder, "run grains.json");
  CAPTURE(result.err);
  REQUIRE(result.exit == 0);
  const auto at = result.out.find("meetings     ");
  REQUIRE(at != std::string::npos);
  const std::string line = result.out.substr(at, result.out.find('\n', at) - at);
  CHECK(line.find(" a particle, ") != std::string::npos);
  CHECK(line.ends_with(" at most, 0 lists too long"));
  const auto found = json::parse(run(folder, "run grains.json --json").out)["meet"];
  CHECK(found["pairs"].get<double>() > 1);
  CHECK(found["pairs"].get<double>() <= found["most"].get<double>());
  CHECK(found["most"].get<int>() <= 24);
  CHECK(found["rebuilt"].get<int>() >= 1);
  CHECK(found["overlap"]["mean"].get<double>() <= found["overlap"]["most"].get<double>());
  CHECK(found["overlap"]["most"].get<double>() < 0.5);
  CHECK(found["stretch_limit"].is_null());
  CHECK(found["crossings"].is_null());
}

TEST_CASE("a list that is too long stops a run, and nothing is written") {
  const ScratchFolder folder("meet-long");
  write_grains(folder);
  const auto result = run(folder, "run grains.json --set meet.most_neighbours=2 --out grains.csv");
  CHECK(result.exit == 3);
  CHECK(result.err.find("grains.json: meet.most_neighbours is 2, and between ") != std::string::npos);
  CHECK(result.err.find(" a particle has more within reach: must be larger: try 4") != std::string::npos);
  CHECK(!std::filesystem::exists(folder.path() / "grains.csv"));
}

TEST_CASE("run warns of cloth stretched so far that cloth fits through, and the cure that it names helps") {
  const ScratchFolder folder("meet-cross");
  write_sheet(folder, "20");
  const json report = json::parse(run(folder, "run sheet.json --json").out);
  const double limit = std::sqrt(2) * 0.8;
  CHECK(is_close(report["meet"]["stretch_limit"].get<double>(), limit, 1e-6));
  const double stretch = report["stretch"]["most"].get<double>();
  REQUIRE(stretch > limit);
  REQUIRE(report["warnings"].size() == 1);
  const json& warning = report["warnings"][0];
  CHECK(warning["code"] == "may_cross");
  CHECK(warning["value"] == stretch);
  CHECK(is_close(warning["limit"].get<double>(), limit, 1e-6));
  const auto text_of = [](const json& of) { return of["warnings"][0]["text"].get<std::string>(); };
  CHECK(text_of(report).ends_with("cloth may have crossed cloth"));  // a net has no triangles
  const std::string of_cloth = text_of(json::parse(run(folder, "run sheet.json --json --set network.shear=1").out));
  CHECK(of_cloth.starts_with("a cell's side was 0.0"));
  CHECK(of_cloth.ends_with(
      "below 0.01131 m nothing passes between particles that keep 0.008 m apart, and beyond it cloth may have "
      "crossed cloth, which it has not at the end"));
  CHECK(run(folder, "run sheet.json --strict").exit == 6);
  // The cure is an accepted number, and helps.
  CHECK(cure_of(report) == R"(Try "strain_limit": 0.21 or stiffer springs, with "thickness": 0.0095 (m) in meet)");
  CHECK(run(folder, "run sheet.json --strict --set network.strain_limit=0.21 --set meet.thickness=0.0095").exit == 0);
  const json thin =
      json::parse(run(folder, "run sheet.json --json --set network.structural=600 --set meet.thickness=0.007").out);
  REQUIRE(cure_of(thin).starts_with("\"thickness\": 0.00"));
  const auto thickness = cure_of(thin).substr(13, cure_of(thin).find(' ', 13) - 13);
  CHECK(run(folder, "run sheet.json --strict --set network.structural=600 --set meet.thickness=" + thickness).exit == 0);
  const std::string long_cells =
      "run sheet.json --set network.structural=2000 --set network.edge_u[0]=0.15 --set network.columns=";
  const json wide = json::parse(run(folder, long_cells + "6 --json").out);
  CHECK(cure_of(wide).starts_with(R"(Try "part_of_cells": 0.95 in meet in place of "thickness": the widest cell is 0.03 m, )"
                                  "and this thickness closes cells of 0.011 m"));
  CHECK(run(folder, long_cells + R"(6 --strict --set 'meet={"part_of_cells": 0.95}')").exit == 0);
  CHECK(run(folder, long_cells + "16 --strict").exit == 0);
  write_sheet(folder, "2000");
  CHECK(json::parse(run(folder, "run sheet.json --json").out)["warnings"] == json::array());
}

TEST_CASE("run warns of overstretched cells also where meet gives a part of cells in place of a thickness") {
  const ScratchFolder folder("meet-part");
  write_sheet(folder, "20");
  const std::string command = R"(run sheet.json --set network.shear=1 --set 'meet={"part_of_cells": 0.8}' )";
  const json report = json::parse(run(folder, command + "--json").out);
  CHECK(is_close(report["meet"]["stretch_limit"].get<double>(), std::sqrt(2) * 0.8, 1e-6));
  REQUIRE(report["warnings"].size() == 1);
  const json& warning = report["warnings"][0];
  CHECK(warning["code"] == "may_cross");
  CHECK(warning["value"].get<double>() > warning["limit"].get<double>());
  const auto text = warning["text"].get<std::string>();
  CHECK(text.starts_with("a cell's side was stretched to "));
  CHECK(text.find("nothing passes between particles that keep 0.8 of their cells apart") != std::string::npos);
  CHECK(cure_of(report) == R"(Try "strain_limit": 0.21 or stiffer springs, with "part_of_cells": 0.95 in meet)");
  CHECK(run(folder, command + "--strict --set network.strain_limit=0.21 --set meet.part_of_cells=0.95").exit == 0);
  CHECK(run(folder, command + "--strict --set network.structural=2000").exit == 0);
}

TEST_CASE("a sheared cell counts as no wider: its diagonals do not count") {
  const ScratchFolder folder("meet-askew");
  write_sheet(folder, "20000");
  const auto result = run(folder, "run sheet.json --json --strict --set network.shear=0.1 --set network.fixed=[0]");
  CHECK(result.exit == 0);
  const json report = json::parse(result.out);
  CHECK(report["stretch"]["most"] > report["meet"]["stretch_limit"]);
  CHECK(report["warnings"] == json::array());
}

// Two motionless sheets of 6 x 6 at 1 cm: one lies flat, the other stands `height` above it.
void write_crossed(const ScratchFolder& folder, const std::string& height) {
  const std::string sheet = R"("mass": 0.36, "structural": 100, "shear": 50, "rows": 6, "columns": 6, "type": "grid", )";
  folder.write("crossed.json", R"({"format": "dvdx-scene/1", "name": "crossed", "step": 0.01, "duration": 0.2,
    "network": [{)" + sheet + R"("origin": [0, 0, 0], "edge_u": [0.05, 0, 0], "edge_v": [0, 0, 0.05]},
      {)" + sheet + R"("origin": [0.012, )" +
                                   height + R"(, 0.013], "edge_u": [0.03, 0, 0.04], "edge_v": [0, 0.05, 0]}],
    "meet": {"thickness": 0.002}})");
}

TEST_CASE("run warns of layers that start too near to meet, and the cure that it names helps") {
  const ScratchFolder folder("meet-layers");
  const auto write = [&](const std::string& height) {
    const std::string sheet = R"("mass": 0.16, "structural": 100, "shear": 50, "rows": 4, "columns": 4, "type": "grid", )";
    folder.write("layers.json", R"({"format": "dvdx-scene/1", "name": "layers", "step": 0.01, "duration": 0.2,
      "network": [{)" + sheet + R"("origin": [0, 0, 0], "edge_u": [0.03, 0, 0], "edge_v": [0, 0, 0.03]},
        {)" + sheet + R"("origin": [0, )" +
                                    height +
                                    R"(, 0], "edge_u": [0.03, 0, 0], "edge_v": [0, 0, 0.03]}],
      "meet": {"thickness": 0.008}})");
  };
  write("0.006");
  const json report = json::parse(run(folder, "run layers.json --json").out);
  REQUIRE(report["warnings"].size() == 1);
  CHECK(report["warnings"][0]["code"] == "layers_pass");
  CHECK(report["warnings"][0]["value"] == 16);
  CHECK(report["meet"]["passing_layers"] == 16);
  CHECK(cure_of(report) == R"(Start layers 0.008 m apart, or set "apart_at_start": false in meet)");
  CHECK(run(folder, "run layers.json --strict").exit == 6);
  CHECK(run(folder, "run layers.json --strict --set meet.apart_at_start=false").exit == 0);
  CHECK(run(folder, "run layers.json --strict --set meet.apart_at_start=true").exit == 0);  // an explicit choice
  const json of_parts = json::parse(run(folder, R"(run layers.json --json --set 'meet={"part_of_cells": 0.8}')").out);
  CHECK(cure_of(of_parts) == "Start layers 0.8 of their widest cell apart");
  write("0.0081");
  CHECK(run(folder, "run layers.json --strict").exit == 0);
}

TEST_CASE("run warns of friction that may add energy, of balls in one another, and of bounces that change the energy") {
  const ScratchFolder folder("meet-warnings");
  const auto codes = [&](const std::string& command) {
    const json report = json::parse(run(folder, command + " --json").out);
    std::vector<std::string> all;
    for (const json& warning : report["warnings"]) all.push_back(warning["code"].get<std::string>());
    return all;
  };
  using Codes = std::vector<std::string>;
  folder.write("cloth.json",
               R"({"format": "dvdx-scene/1", "name": "cloth", "step": 0.01, "duration": 0.05, "network": {"type": "grid",
    "mass": 0.16, "structural": 100, "rows": 4, "columns": 4, "origin": [0, 0, 0], "edge_u": [0.03, 0, 0], "edge_v": [0, 0, 0.03]},
    "meet": {"thickness": 0.008, "friction": 1.3}})");
  CHECK(codes("run cloth.json") == Codes{"grip"});
  CHECK(codes("run cloth.json --set meet.friction=1.2") == Codes{});
  // The upper one of two balls on a floor has a million times the mass of the lower one.
  folder.write("tower.json", R"({"format": "dvdx-scene/1", "name": "tower", "step": 0.016666666666666666, "duration": 1,
    "particles": {"count": 2, "mass": {"values": [1, 1e6]}, "position": {"values": [[0, 0.01, 0], [0, 0.0301, 0]]}},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0}], "meet": {"radius": 0.01}})");
  CHECK(codes("run tower.json") == Codes{"overlap"});
  CHECK(codes("run tower.json --set 'particles.mass={\"values\": [1, 1]}'") == Codes{});
  const auto wall = [](const std::string& normal) {
    return R"({"type": "plane", "offset": -0.05, "restitution": 1, "normal": )" + normal + "}";
  };
  folder.write("gas.json", R"({"format": "dvdx-scene/1", "name": "gas", "step": 0.016666666666666666, "duration": 10,
    "particles": {"count": 2, "position": {"values": [[-0.03, 0.001, 0], [0.02, 0, 0.002]]},
      "velocity": {"values": [[1, 0.3, -0.4], [-0.2, 0.5, 0.7]]}}, "contacts": [)" +
                               wall("[1, 0, 0]") + "," + wall("[-1, 0, 0]") + "," + wall("[0, 1, 0]") + "," +
                               wall("[0, -1, 0]") + "," + wall("[0, 0, 1]") + "," + wall("[0, 0, -1]") +
                               R"(], "meet": {"radius": 0.01, "restitution": 1}})");
  CHECK(codes("run gas.json --precision float64 --set substeps=4") == Codes{"bounces"});
  CHECK(codes("run gas.json --precision float64 --set substeps=16") == Codes{});
  const std::string weight =
      R"(run gas.json --precision float64 --set 'forces=[{"type": "constant", "acceleration": [0, -1, 0]}]')";
  CHECK(codes(weight + " --set substeps=1 --duration 40") == Codes{"bounces"});
  CHECK(codes(weight + " --set substeps=64") == Codes{});
  // Fast balls in a box with too few sub-steps: bounces are missed, and most of the energy is lost.
  folder.write("loss.json", R"({"format": "dvdx-scene/1", "name": "loss", "step": 0.016666666666666666, "duration": 0.5,
    "particles": {"count": 64, "velocity": {"uniform": {"min": [-20, -20, -20], "max": [20, 20, 20], "seed": 1}}, "position":
      {"lattice": {"min": [-0.045, -0.045, -0.045], "max": [0.046, 0.046, 0.046], "spacing": 0.03}}}, "contacts": [{"type": "box",
      "center": [0, 0, 0], "half_extents": [0.12, 0.12, 0.12], "side": "inside", "restitution": 1}],
    "meet": {"radius": 0.01, "restitution": 1, "most_neighbours": 63}})");
  CHECK(codes("run loss.json") == Codes{"bounces"});
  CHECK(codes("run loss.json --set meet.restitution=0.9") == Codes{});
  CHECK(codes("run loss.json --set substeps=200") == Codes{});
}

TEST_CASE("run counts where edges of cloth go through its triangles, and warns of cloth that has crossed") {
  const ScratchFolder folder("meet-crossed");
  write_crossed(folder, "-0.025");
  const json report = json::parse(run(folder, "run crossed.json --json").out);
  const auto end = report["meet"]["crossings"]["end"].get<int>();
  CHECK(end >=
        10);  // each of the 5 crossing cells has at least one upright or slanting edge that crosses, and so has the met one
  CHECK(report["meet"]["crossings"]["most"] >= end);
  REQUIRE(report["warnings"].size() == 1);
  CHECK(report["warnings"][0]["code"] == "crossed");
  CHECK(report["warnings"][0]["value"] == end);
  CHECK(cure_of(report).starts_with("Try --substeps "));
  CHECK(cure_of(report).ends_with(R"(, and "rounds": 16 in meet. "thickness": 0.0073 (m) in meet closes such cells)"));
  const auto text = run(folder, "run crossed.json --strict");
  CHECK(text.exit == 6);
  CHECK(text.out.find("crossings    " + std::to_string(end) + " at the end, ") != std::string::npos);
  write_crossed(folder, "0.005");
  const json apart = json::parse(run(folder, "run crossed.json --json --strict").out);
  CHECK(apart["meet"]["crossings"] == json{{"end", 0}, {"most", 0}});
}

TEST_CASE("the shipped cradle swings on: one ball comes, and one leaves at the other end") {
  const ScratchFolder folder("meet-cradle");
  // The first ball reaches the bottom after a quarter of its period, 0.29 s at 45 degrees, and the last one returns half a
  // period later.
  const auto result = run(folder, "run '" + dvdx::test::scenes() + "/cradle.json' --json --duration 0.5 --out end.csv");
  REQUIRE(result.exit == 0);
  const json report = json::parse(result.out);
  CHECK(report["warnings"] == json::array());
  CHECK(is_close(report["energy"]["end"].get<double>(), report["energy"]["start"].get<double>(), 1e-4));
  std::vector<double> x;
  std::istringstream rows(folder.read("end.csv"));
  for (std::string row; std::getline(rows, row);) {
    if (!row.starts_with("60,")) continue;
    std::istringstream cells(row);
    std::string cell;
    for (int k = 0; k < 4; ++k) std::getline(cells, cell, ',');
    x.push_back(std::stod(cell));
  }
  REQUIRE(x.size() == 10);
  for (std::size_t ball = 5; ball < 9; ++ball) CHECK(std::abs(x[ball] - x[ball - 5]) < 1e-4);
  CHECK(x[9] - x[4] > 0.3 * std::sin(0.7));
}

TEST_CASE("commands that compare with a reference refuse a scene with meet") {
  const ScratchFolder folder("meet-refused");
  write_grains(folder);
  for (const char* command : {"report grains.json", "tune grains.json --error 1e-3"}) {
    CAPTURE(std::string(command));
    const auto result = run(folder, command);
    CHECK(result.exit == 3);
    CHECK(result.err.find("grains.json: meet: must be left out for dvdx ") != std::string::npos);
  }
}

TEST_CASE("a page holds the radius of balls, one for all or one for each, and none for cloth") {
  const ScratchFolder folder("meet-page");
  write_grains(folder);
  auto file = dvdx::tool::read_scene(folder / "grains.json");
  const auto scene_of = [&] {
    return dvdx::tool::scene_json({.target = "x.html", .particles = file.particles.count, .states = 1, .scene = &file});
  };
  CHECK(scene_of()["radii"] == 0.05);
  std::vector<double> each(64, 0.25);
  each[3] = 0.5;
  file.scene.meet->radius = each;
  CHECK(scene_of()["radii"] == each);
  file.scene.meet = dvdx::Meet{.thickness = 0.1};
  CHECK(!scene_of().contains("radii"));
}

// Two balls a step are poured into a box, and live for at most 0.4 s: always fewer than the capacity.
void write_pour(const ScratchFolder& folder) {
  folder.write("pour.json", R"({"format": "dvdx-scene/1", "name": "pour", "step": 0.01, "duration": 0.6, "capacity": 100,
    "particles": {"mass": 0.1},
    "emitters": [{"type": "disc", "center": [0.2, 0.4, 0.2], "normal": [0, 1, 0], "radius": 0.08, "rate": 200,
      "velocity": [0, -2, 0], "lifetime": {"min": 0.2, "max": 0.4}, "seed": 3}],
    "removal": {"not_finite": "removed"},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0},
      {"type": "plane", "normal": [1, 0, 0], "offset": 0.05}, {"type": "plane", "normal": [-1, 0, 0], "offset": -0.35},
      {"type": "plane", "normal": [0, 0, 1], "offset": 0.05}, {"type": "plane", "normal": [0, 0, -1], "offset": -0.35}],
    "meet": {"radius": 0.02, "friction": 0.3}})");
}

TEST_CASE("run, explain and pictures take balls that are poured, meet and go") {
  const ScratchFolder folder("meet-pour");
  write_pour(folder);
  const auto result = run(folder, "run pour.json --json --out pour.png");
  CAPTURE(result.err);
  REQUIRE(result.exit == 0);
  const json report = json::parse(result.out);
  CHECK(report["born"] == 120);
  CHECK(report["removed"] > 20);
  CHECK(report["substeps"] > 1);
  CHECK(report["meet"]["pairs"] > 0.2);
  CHECK(std::filesystem::exists(folder.path() / "pour.png"));
  const auto words = run(folder, "explain pour.json").out;
  CHECK(words.find("meetings     100 balls of 0.02 m") != std::string::npos);
  CHECK(words.find("one step of all of them, sub-step by sub-step: they meet") != std::string::npos);
}

TEST_CASE("a run of poured balls with too many neighbours names the key and the time") {
  const ScratchFolder folder("meet-pour-long");
  write_pour(folder);
  const auto result = run(folder, "run pour.json --set meet.most_neighbours=1");
  CHECK(result.exit == 3);
  CHECK(result.err.find("pour.json: meet.most_neighbours is 1, and between ") != std::string::npos);
}

TEST_CASE("keys that do not go with balls that come and go are refused by name") {
  const ScratchFolder folder("meet-pour-refused");
  write_pour(folder);
  const std::vector<std::pair<std::string, std::string>> refused = {
      {"meet.apart_at_start=true", "meet.apart_at_start is true: must be false or left out of a scene whose particles come"},
      {"removal.order=any", "removal.order is any: must be kept where particles meet"},
      {"meet.groups={\"of\": [], \"meet\": []}", "meet.groups is there: must be left out where particles come and go"},
  };
  for (const auto& [change, message] : refused) {
    const auto result = run(folder, "explain pour.json --set '" + change + "'");
    CAPTURE(result.err);
    CHECK(result.exit == 3);
    CHECK(result.err.find(message) != std::string::npos);
  }
}

}  // namespace meet_test
