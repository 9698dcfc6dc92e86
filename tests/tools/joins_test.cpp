// The stretch of springs and rods in a run, and the run's messages about it.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace joins_test {

using dvdx::test::run;
using dvdx::test::ScratchFolder;
using nlohmann::json;

json report_of(const ScratchFolder& folder, const std::string& arguments, int exit = 0) {
  CAPTURE(arguments);
  const auto result = run(folder, "run " + arguments + " --json");
  CAPTURE(result.err);
  REQUIRE(result.exit == exit);
  return json::parse(result.out);
}

constexpr double g = 9.81;

// A weight released on a spring of 1 m at rest length moves down by m g/k, and by as much again.
TEST_CASE("run reports the stretch of springs: a released weight goes twice as far as it hangs") {
  const ScratchFolder folder("stretch");
  folder.write("weight.json", R"({"format": "dvdx-scene/1", "name": "weight", "step": 0.001, "duration": 2,
    "particles": {"count": 2, "mass": 1, "position": {"values": [[0, 2, 0], [0, 1, 0]]}}, "fixed": [0],
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "network": {"type": "springs", "pairs": [[1, 0]], "stiffness": 100, "rest_length": 1}})");
  const json report = report_of(folder, "weight.json --precision float64");
  CHECK(report["stretch"]["most"].get<double>() == doctest::Approx(1 + 2 * g / 100).epsilon(0.01));
  CHECK(report["stretch"]["springs"] == json({0, 1}));
  CHECK(report["rods"].is_null());
  CHECK(report["energy"]["most"].get<double>() == doctest::Approx(3 * g).epsilon(1e-3));  // including the fixed one's
  CHECK(std::abs(report["energy"]["given"].get<double>()) < 1e-9);
  CHECK(report["warnings"] == json::array());
  const auto table = run(folder, "run weight.json").out;
  CHECK(table.find("\nstretch      1.1") != std::string::npos);
  CHECK(table.find(" at most; forces can have given ") != std::string::npos);
}

TEST_CASE("run reports how far rods are off, and whether a scene joined by rods alone heats") {
  const ScratchFolder folder("rods");
  folder.write("pendulum.json", R"({"format": "dvdx-scene/1", "name": "pendulum", "step": 0.01, "duration": 1,
    "particles": {"count": 3, "mass": 1, "position": {"values": [[0, 0, 0], [1, 0, 0], [1, 5, 0]]}}, "fixed": [0],
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "constraints": [{"type": "point", "particle": 2, "at": [1, 5, 0]}, {"type": "distance", "pairs": [[0, 1]], "length": 1}]})");
  const json report = report_of(folder, "pendulum.json");
  CHECK(report["heating"] == false);
  CHECK(report["stretch"].is_null());
  CHECK(report["rods"]["most"].get<double>() < 1e-5);
  CHECK(report["warnings"] == json::array());
  // A rod that is too long at the start has that error at the start.
  const json wrong = report_of(folder, "pendulum.json --set constraints[1].length=0.8");
  CHECK(wrong["rods"]["most"].get<double>() == doctest::Approx(0.25));
  CHECK(wrong["rods"]["time"] == 0);
  CHECK(wrong["rods"]["constraint"] == 1);
  CHECK(wrong["rods"]["between"] == json({0, 1}));
  REQUIRE(wrong["warnings"].size() >= 1);
  CHECK(wrong["warnings"][0]["code"] == "rods");
  CHECK(wrong["warnings"][0]["cure"].get<std::string>().starts_with("Start with it at its length"));
  CHECK(run(folder, "run pendulum.json --strict --set constraints[1].length=0.8").exit == 6);
}

// A net of 5 x 5 knots that falls into one corner, with a load of a hundred knots in the opposite one.
TEST_CASE("crossing ropes take the sub-steps that their possible load needs, and one sub-step overstretches them") {
  const ScratchFolder folder("net");
  json places = json::array(), pairs = json::array();
  for (int i = 0; i < 25; ++i) {
    places.push_back({0.25 * (i / 5), 0, 0.25 * (i % 5)});
    if (i % 5 != 4) pairs.push_back({i, i + 1});
    if (i < 20) pairs.push_back({i, i + 5});
  }
  std::vector<double> mass(25, 0.01);
  mass[24] = 1;
  const json net{{"format", "dvdx-scene/1"},
                 {"name", "net"},
                 {"step", 0.05},
                 {"duration", 1.5},
                 {"particles", {{"count", 25}, {"mass", {{"values", mass}}}, {"position", {{"values", places}}}}},
                 {"fixed", {0}},
                 {"forces", {{{"type", "constant"}, {"acceleration", {0, -9.81, 0}}}}},
                 {"constraints", {{{"type", "distance"}, {"pairs", pairs}, {"length", "start"}, {"bound", "at_most"}}}}};
  folder.write("net.json", net.dump());
  const json one = report_of(folder, "net.json --substeps 1");
  REQUIRE(one["warnings"].size() == 1);
  CHECK(one["warnings"][0]["code"] == "rods");
  CHECK(one["warnings"][0]["cure"] == "Try --substeps auto, or 4 if that is not enough");
  const json cured = report_of(folder, "net.json");
  // 1.24 kg on two ropes of 0.25 m to a knot of 0.01 kg: omega^2 = 2 * 4 * 1.24 g / (0.01 * 0.25) is at most (2 / 0.005 s)^2.
  CHECK(cured["substeps"] == 5);
  CHECK(cured["rods"]["most"].get<double>() < 0.03);
  CHECK(cured["warnings"] == json::array());
}

// 100 kg on 20 springs of 1e6 N/m, with one sweep to and fro of extended position-based dynamics: they would stretch by metres.
TEST_CASE("run warns of springs that hold more energy than was given, and the cure that it names helps") {
  const ScratchFolder folder("soft");
  std::string places, pairs;
  for (int i = 0; i <= 20; ++i) {
    places += (i == 0 ? "[" : ", [") + std::to_string(-0.1 * i) + ", 0, 0]";
    if (i > 0) pairs += (i == 1 ? "[" : ", [") + std::to_string(i - 1) + ", " + std::to_string(i) + "]";
  }
  std::string mass = "0.1";
  for (int i = 1; i <= 20; ++i) mass += i == 20 ? ", 100" : ", 0.1";
  folder.write("rope.json", R"({"format": "dvdx-scene/1", "name": "rope", "step": 0.016666666666666666, "duration": 1,
    "particles": {"count": 21, "mass": {"values": [)" +
                                mass + R"(]}, "position": {"values": [)" + places + R"(]}}, "fixed": [0],
    "forces": [{"type": "constant", "acceleration": [-9.81, 0, 0]}],
    "network": {"type": "springs", "pairs": [)" +
                                pairs + R"(], "stiffness": 1e6, "rest_length": 0.1,
      "scheme": "sequential", "substeps": 1}})");
  const std::string soft = "rope.json --set network.theta=1 --set network.sweep=forward";
  const json report = report_of(folder, soft);
  REQUIRE(report["warnings"].size() == 1);
  CHECK(report["warnings"][0]["code"] == "stretch");
  CHECK(report["warnings"][0]["value"].get<double>() > 1.3 * report["warnings"][0]["limit"].get<double>());
  CHECK(report["stretch"]["most"].get<double>() > 2);
  CHECK(report["heating"] == false);
  CHECK(run(folder, "run " + soft + " --strict").exit == 6);
  const json cured = report_of(folder, soft + " --substeps auto");
  CHECK(cured["warnings"] == json::array());
  CHECK(cured["stretch"]["most"].get<double>() < 1.05);
  CHECK(report_of(folder, "rope.json")["warnings"] == json::array());  // lines of springs carry it with one sub-step
}

// 16 x 16 particles of 1/256 kg on sides of 0.1 m: omega^2 = 2 * 4 * g * 256 / 0.1 is at most (2 / (0.01 s / 3))^2.
TEST_CASE("run reports the sub-steps that a sheet's strain limit needs") {
  const ScratchFolder folder("strain");
  folder.write("sheet.json", R"({"format": "dvdx-scene/1", "name": "sheet", "step": 0.01, "duration": 0.02,
    "network": {"type": "grid", "rows": 16, "columns": 16, "origin": [0, 0, 0], "edge_u": [1.5, 0, 0], "edge_v": [0, 0, 1.5],
      "mass": 1, "structural": 20, "scheme": "sequential", "strain_limit": 0}})");
  const std::string falls = "sheet.json --set forces='[{\"type\": \"constant\", \"acceleration\": [0, -9.81, 0]}]'";
  CHECK(report_of(folder, falls)["substeps"] == 3);
  CHECK(report_of(folder, "sheet.json")["substeps"] == 1);
}

TEST_CASE("run of a scene without joints reports no stretch, rods or heating") {
  const ScratchFolder folder("unjoined");
  folder.write("fall.json", R"({"format": "dvdx-scene/1", "name": "fall", "step": 0.01, "duration": 0.1,
    "particles": {"count": 2, "mass": 1}, "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]})");
  const json report = report_of(folder, "fall.json");
  for (const char* key : {"stretch", "rods", "heating", "warnings"}) CHECK(!report.contains(key));
  CHECK(!report["energy"].contains("most"));
}

TEST_CASE("springs and rods as long as at the start take their lengths from the positions in a file") {
  const ScratchFolder folder("places");
  folder.write("places.csv", "0,0,0\n1,0,0\n2,0,0\n");
  folder.write("start.json", R"({"format": "dvdx-scene/1", "name": "start", "step": 0.01, "duration": 0.1,
    "particles": {"count": 3, "mass": 1, "position": {"file": "places.csv"}},
    "network": {"type": "springs", "pairs": [[0, 1]], "stiffness": 100, "rest_length": "start"}})");
  CHECK(report_of(folder, "start.json")["stretch"]["most"] == 1);
  folder.write("rods.json", R"({"format": "dvdx-scene/1", "name": "rods", "step": 0.01, "duration": 0.1,
    "particles": {"count": 3, "mass": 1, "position": {"file": "places.csv"}},
    "constraints": [{"type": "distance", "pairs": [[1, 2]], "length": "start"}]})");
  CHECK(report_of(folder, "rods.json")["rods"]["most"] == 0);
}

TEST_CASE("run warns of too few sub-steps to bring a sheet to rest, and the number that it names suffices") {
  const ScratchFolder folder("swings_on");
  folder.write("flat.json", R"({"format": "dvdx-scene/1", "name": "flat", "step": 0.016666666666666666, "duration": 8,
    "network": {"type": "grid", "rows": 40, "columns": 40, "origin": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1],
      "mass": 1, "structural": 300, "shear": 300, "fixed": "corners_top", "scheme": "sequential", "substeps": 1},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}, {"type": "drag", "coefficient": 0.001875}]})");
  const auto fastest = [&] {  // m/s
    std::istringstream rows(folder.read("end.csv"));
    std::string row;
    std::getline(rows, row);
    double most = 0;
    while (std::getline(rows, row)) {
      std::array<double, 9> of{};  // step, time, particle, x, v
      std::replace(row.begin(), row.end(), ',', ' ');
      std::istringstream numbers(row);
      for (double& number : of) numbers >> number;
      REQUIRE(numbers);
      most = std::max(most, std::hypot(of[6], of[7], of[8]));
    }
    return most;
  };
  const json report = report_of(folder, "flat.json --out end.csv");
  CHECK(fastest() > 0.1);
  REQUIRE(report["warnings"].size() == 1);
  const json& warning = report["warnings"][0];
  CHECK(warning["code"] == "may_swing_on");
  CHECK(warning["value"].get<double>() > 7);
  CHECK(warning["cure"] == "Try --substeps 2, or --substeps auto");
  const json cured = report_of(folder, "flat.json --substeps 2 --out end.csv");
  CHECK(fastest() < 0.01);
  CHECK(cured["warnings"] == json::array());
  CHECK(cured["sweep_estimate"]["turning"].get<double>() <= 7);
}

// 24 rods in a ring of 1 m that spins at 20 m/s: 24 kg, 4800 J.
TEST_CASE("run warns of rods that lose energy without a cause, and the cure that it names helps") {
  const ScratchFolder folder("ring");
  constexpr int n = 24;
  json places = json::array(), speeds = json::array(), pairs = json::array();
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * 3.14159265358979 * i / n;
    places.push_back({std::cos(angle), std::sin(angle), 0});
    speeds.push_back({-20 * std::sin(angle), 20 * std::cos(angle), 0});
    pairs.push_back({i, (i + 1) % n});
  }
  const json ring{
      {"format", "dvdx-scene/1"},
      {"name", "ring"},
      {"step", 1.0 / 60},
      {"duration", 3},
      {"particles", {{"count", n}, {"mass", 1}, {"position", {{"values", places}}}, {"velocity", {{"values", speeds}}}}},
      {"constraints", {{{"type", "distance"}, {"pairs", pairs}, {"length", "start"}}}}};
  folder.write("ring.json", ring.dump());
  const json one = report_of(folder, "ring.json");
  REQUIRE(one["warnings"].size() == 1);
  const json& warning = one["warnings"][0];
  CHECK(warning["code"] == "loses");
  CHECK(warning["value"] == one["energy"]["end"]);
  CHECK(warning["value"].get<double>() < 2400);
  CHECK(warning["limit"].get<double>() == doctest::Approx(0.9 * 4800).epsilon(1e-3));
  CHECK(warning["cure"] == "Try --substeps 4");
  const json cured = report_of(folder, "ring.json --substeps 4");
  CHECK(cured["warnings"] == json::array());
  CHECK(cured["energy"]["end"].get<double>() == doctest::Approx(4800).epsilon(1e-3));
  // Ropes that go taut take energy, and so does a rod whose ends start apart.
  CHECK(report_of(folder, "ring.json --set constraints[0].bound=at_most")["warnings"] == json::array());
  folder.write("parting.json", R"({"format": "dvdx-scene/1", "name": "parting", "step": 0.01, "duration": 0.1,
    "particles": {"count": 2, "mass": 1, "position": {"values": [[0, 0, 0], [1, 0, 0]]},
      "velocity": {"values": [[-1, 0, 0], [1, 0, 0]]}},
    "constraints": [{"type": "distance", "pairs": [[0, 1]], "length": 1}]})");
  const json parting = report_of(folder, "parting.json");
  CHECK(parting["energy"]["end"].get<double>() < 1e-9);
  CHECK(parting["warnings"] == json::array());
}

}  // namespace joins_test
