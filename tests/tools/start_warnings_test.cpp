// Warnings at the start of a run: particles inside a surface, numbers probably in other units, and a long duration.
#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"
#include "watch/long_run_watch.hpp"

namespace start_warnings_test {

using dvdx::test::run;
using dvdx::test::ScratchFolder;
using nlohmann::json;

// The warnings with one code.
json warnings_of(const ScratchFolder& folder, const std::string& arguments, const std::string& code = "start_inside") {
  CAPTURE(arguments);
  const auto result = run(folder, "run " + arguments + " --json");
  CAPTURE(result.err);
  REQUIRE(result.exit == 0);
  const json report = json::parse(result.out);
  json found = json::array();
  for (const json& warning : report["warnings"]) {
    if (warning["code"] == code) found.push_back(warning);
  }
  return found;
}

// 5 x 5 particles with edges of 0.25 m, above a ball of 0.5 m at the origin.
void write_sheet(const ScratchFolder& folder) {
  folder.write("sheet.json", R"({"format": "dvdx-scene/1", "name": "sheet", "step": 0.01, "duration": 0.02,
    "network": {"type": "grid", "rows": 5, "columns": 5, "origin": [-0.5, 0.1, -0.5], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1],
      "mass": 1, "structural": 100},
    "contacts": [{"type": "sphere", "center": [0, 0, 0], "radius": 0.5}]})");
}

TEST_CASE("run warns of cloth that starts inside a ball, by how much, and the cure that it names helps") {
  const ScratchFolder folder("inside");
  write_sheet(folder);
  const json warnings = warnings_of(folder, "sheet.json");
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0]["value"].get<double>() == doctest::Approx(0.4).epsilon(1e-6));
  CHECK(warnings[0]["limit"].get<double>() == doctest::Approx(1e-4));
  const auto text = warnings[0]["text"].get<std::string>();
  CHECK(text.find("9 particles start inside a surface, particle 12 by 0.4 m") == 0);  // those 0.25 and 0.35 m off the axis too
  CHECK(warnings[0]["cure"].get<std::string>().find("particle 12 is out of it by (0, 0.4, 0) m") != std::string::npos);
  CHECK(warnings[0]["cure"].get<std::string>().find("\"push_out\": 0.5 (m/s) at the top of the scene it is out in 0.8 s") !=
        std::string::npos);
  CHECK(run(folder, "run sheet.json --strict").exit == 6);
  CHECK(run(folder, "run sheet.json --strict --duration 1.5 --set push_out=0.5").exit == 0);
  // Sub-steps do not cure sheets that heat from this cause.
  const json heating = warnings_of(folder, "sheet.json --duration 0.5", "heating");
  REQUIRE(heating.size() == 1);
  CHECK(heating[0]["cure"] == warnings[0]["cure"]);
  // The cure for a scheme that refuses push_out does not name it.
  const json by_fourth_order = warnings_of(folder, "sheet.json --scheme fourth_order");
  REQUIRE(by_fourth_order.size() == 1);
  CHECK(by_fourth_order[0]["cure"].get<std::string>().find("push_out") == std::string::npos);
  CHECK(warnings_of(folder, "sheet.json --precision float64")[0]["text"] == text);
  CHECK(warnings_of(folder, "sheet.json --set network.origin[1]=0.5") == json::array());
}

TEST_CASE("run does not warn of particles that are pinned inside, inside by rounding alone, or free") {
  const ScratchFolder folder("outside");
  write_sheet(folder);
  // The ball reaches only the middle particle, which a pin may hold inside.
  const std::string one = "sheet.json --set contacts[0].radius=0.2";
  CHECK(warnings_of(folder, one).size() == 1);
  CHECK(warnings_of(folder, one + " --set network.fixed=[12]") == json::array());
  // A floor below which float32 rounds the sheet.
  folder.write("floor.json", R"({"format": "dvdx-scene/1", "name": "floor", "step": 0.01, "duration": 0.02,
    "network": {"type": "grid", "rows": 5, "columns": 5, "origin": [0, 0.7, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1],
      "mass": 1, "structural": 100},
    "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0.7}]})");
  CHECK(warnings_of(folder, "floor.json") == json::array());
  CHECK(warnings_of(folder, "floor.json --set contacts[0].offset=0.8").size() == 1);
  folder.write("free.json", R"({"format": "dvdx-scene/1", "name": "free", "step": 0.01, "duration": 0.02,
    "particles": {"count": 1, "mass": 1}, "contacts": [{"type": "sphere", "radius": 0.5, "center": [0, 0.1, 0]}]})");
  const auto free = run(folder, "run free.json --json");
  CHECK(free.exit == 0);
  CHECK(free.err.find("warning") == std::string::npos);
}

TEST_CASE("run warns of particles between two surfaces that overlap, and the cure that it names helps") {
  const ScratchFolder folder("pinched");
  // Jaws that close to a gap of -1 cm, beside a third surface far away.
  const auto jaws = [&](const char* upper, const char* motion) {
    folder.write("jaws.json", std::string(R"({"format": "dvdx-scene/1", "name": "jaws", "step": 0.01, "duration": 0.2,
      "network": {"type": "grid", "rows": 3, "columns": 3, "origin": [-0.1, 0, -0.1], "edge_u": [0.2, 0, 0],
        "edge_v": [0, 0, 0.2], "mass": 0.1, "structural": 100},
      "motions": {"close": {"keys": [{"time": 0}, {"time": 0.1, "translation": [0, )") +
                                  motion + R"(, 0]}]}},
      "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": -0.01, "friction": 0.5},
                   {"type": "plane", "normal": [1, 0, 0], "offset": -9},
                   {"type": "box", "center": [0, )" +
                                  upper + R"(, 0], "half_extents": [0.3, 0.1, 0.3], "friction": 0.5, "motion": "close"}]})");
  };
  jaws("0.12", "-0.04");
  const json warnings = warnings_of(folder, "jaws.json", "pinched");
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0]["value"].get<double>() == doctest::Approx(0.005).epsilon(1e-3));
  CHECK(warnings[0]["text"].get<std::string>().find(
            " is between two surfaces at 0.2 s that overlap there, 0.005 m inside both") != std::string::npos);
  CHECK(warnings[0]["cure"].get<std::string>().find("Keep the surfaces 0.01 m further apart") == 0);
  CHECK(run(folder, "run jaws.json --strict").exit == 6);
  CHECK(run(folder, "run jaws.json --strict --set push_out=0.5").exit == 6);
  jaws("0.13", "-0.04");  // by the value in the cure
  CHECK(warnings_of(folder, "jaws.json", "pinched") == json::array());
  CHECK(run(folder, "run jaws.json --strict").exit == 0);
}

TEST_CASE("a pinched vertex of a mesh is named by its number in the file") {
  const ScratchFolder folder("pinched-vertex");
  folder.write("mesh.obj", "v 5 5 5\nv -1 0.005 0\nv 0 0.005 -1\nv 0 0.005 0\nf 2 3 4\n");  // the first belongs to no face
  folder.write("mesh.json", R"({"format": "dvdx-scene/1", "name": "mesh", "step": 0.01, "duration": 0.02,
    "network": {"type": "mesh", "file": "mesh.obj", "mass": 0.1, "edge": 10},
    "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0.01},
                 {"type": "box", "center": [0, 0.23, 0], "half_extents": [0.25, 0.25, 0.25]}]})");
  const json warnings = warnings_of(folder, "mesh.json", "pinched");
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0]["text"].get<std::string>().find("particle 3 is between two surfaces") == 0);
}

// 9 x 9 particles on a metre, just above a ball of half a metre. The line between two particles on it, 0.177 m apart, is 8 mm
// inside.
TEST_CASE("run warns of a ball that comes through cloth between its particles, and the thickness that it names helps") {
  const ScratchFolder folder("pokes");
  folder.write("drape.json", R"({"format": "dvdx-scene/1", "name": "drape", "step": 0.01, "duration": 0.4,
    "network": {"type": "grid", "rows": 9, "columns": 9, "origin": [-0.5, 0.52, -0.5], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1],
      "mass": 0.3, "structural": 200, "shear": 100, "damping": 0.05},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": -2},
                 {"type": "sphere", "center": [0, 0, 0], "radius": 0.5}]})");
  const json warnings = warnings_of(folder, "drape.json", "pokes_through");
  REQUIRE(warnings.size() == 1);
  const auto depth = warnings[0]["value"].get<double>();
  CHECK(depth > 0.006);
  CHECK(depth < 0.011);
  CHECK(warnings[0]["limit"].get<double>() < 0.0015);
  CHECK(warnings[0]["text"].get<std::string>().find("contacts[1] comes 0.0") == 0);
  const auto cure = warnings[0]["cure"].get<std::string>();
  REQUIRE(cure.find("\"thickness\": 0.0") == 0);
  const auto thickness = std::stod(cure.substr(cure.find(':') + 1));
  CHECK(thickness >= depth);
  CHECK(run(folder, "run drape.json --strict").exit == 6);
  CHECK(run(folder, "run drape.json --strict --set contacts[1].thickness=" + std::to_string(thickness)).exit == 0);
  // A ball may come through a net. Inside a hollow ball nothing can come through the cloth.
  CHECK(warnings_of(folder, "drape.json --set network.shear=0", "pokes_through") == json::array());
  CHECK(warnings_of(folder, "drape.json --set contacts[1].side=inside --set contacts[1].radius=0.9", "pokes_through") ==
        json::array());
}

TEST_CASE("run warns of sheets in millimetres or grams") {
  const ScratchFolder folder("units");
  const auto sheet = [&](const char* side, const char* mass) {
    folder.write("sheet.json", std::string(R"({"format": "dvdx-scene/1", "name": "sheet", "step": 0.01, "duration": 0.02,
      "network": {"type": "grid", "rows": 10, "columns": 10, "origin": [0, 0, 0], "edge_u": [)") +
                                   side + R"(, 0, 0], "edge_v": [0, 1, 0], "structural": 1e-6, "mass": )" + mass + "}}");
    return warnings_of(folder, "sheet.json", "units");
  };
  CHECK(sheet("100", "1e-4") == json::array());
  const json wide = sheet("1000", "1e-4");
  REQUIRE(wide.size() == 1);
  CHECK(wide[0]["value"] == 1000);
  CHECK(wide[0]["limit"] == 100);
  CHECK(wide[0]["text"].get<std::string>().find("network is 1000 m wide") == 0);
  const json light = sheet("100", "0.9e-4");
  REQUIRE(light.size() == 1);
  CHECK(light[0]["value"].get<double>() == doctest::Approx(0.9e-6));
  CHECK(light[0]["limit"] == 1e-6);
}

// The first quarter of a second gives 10 ms a step.
TEST_CASE("a run is reported as long if its remaining steps take longer than a minute") {
  dvdx::tool::LongRunWatch watch;
  CHECK_FALSE(watch.take(0.1, 10, 1000000));
  const auto seconds = watch.take(0.2, 20, 6001);
  REQUIRE(seconds);
  CHECK(*seconds == doctest::Approx(60.01));
  CHECK_FALSE(watch.take(100, 1, 1000000));  // it is reported once
  dvdx::tool::LongRunWatch cheap;
  CHECK_FALSE(cheap.take(0.3, 30, 5999));
  CHECK_FALSE(cheap.take(100, 1, 1000000));
}

TEST_CASE("run warns of springs only a few roundings long at the start, and a higher precision ends the warning") {
  const ScratchFolder folder("rounding");
  const auto apart = [&](const char* distance, const std::string& options) {
    folder.write("apart.json", std::string(R"({"format": "dvdx-scene/1", "name": "apart", "step": 0.01, "duration": 0.02,
      "network": [{"type": "grid", "rows": 5, "columns": 5, "origin": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, 1, 0],
                    "mass": 1, "structural": 100},
                  {"type": "grid", "rows": 5, "columns": 5, "origin": [)") +
                                   distance + R"(, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, 1, 0],
                    "mass": 1, "structural": 100}]})");
    return warnings_of(folder, "apart.json" + options, "rounding");
  };
  const json warnings = apart("1e6", "");
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0]["value"].get<double>() == doctest::Approx(0.25 / (1e6 * 0x1p-23)).epsilon(1e-4));
  CHECK(warnings[0]["limit"] == 100);
  CHECK(warnings[0]["text"].get<std::string>().find("is 0.25 m long, and its particles' places are held to 0.12 m there") !=
        std::string::npos);
  CHECK(apart("1e6", " --precision float32_compensated") == json::array());
  CHECK(apart("1e6", " --precision float64") == json::array());
  CHECK(apart("1e4", "") == json::array());
}

}  // namespace start_warnings_test
