// How far what joins particles goes in a run, and what the run says of it.
#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>
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

// A weight let go on a spring of 1 m that is as long as at rest: it goes m g/k down, and as far again.
TEST_CASE("run says how far springs stretch: a weight on a spring goes twice as far as it hangs") {
  const ScratchFolder folder("stretch");
  folder.write("weight.json", R"({"format": "dvdx-scene/1", "name": "weight", "step": 0.001, "duration": 2,
    "particles": {"count": 2, "mass": 1, "position": {"values": [[0, 2, 0], [0, 1, 0]]}}, "fixed": [0],
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "network": {"type": "springs", "pairs": [[1, 0]], "stiffness": 100, "rest_length": 1}})");
  const json report = report_of(folder, "weight.json --precision float64");
  CHECK(report["stretch"]["most"].get<double>() == doctest::Approx(1 + 2 * g / 100).epsilon(0.01));
  CHECK(report["stretch"]["springs"] == json({0, 1}));
  CHECK(report["rods"].is_null());
  CHECK(report["energy"]["most"].get<double>() == doctest::Approx(3 * g).epsilon(1e-3));  // with the fixed one's
  CHECK(std::abs(report["energy"]["given"].get<double>()) < 1e-9);
  CHECK(report["warnings"] == json::array());
  const auto table = run(folder, "run weight.json").out;
  CHECK(table.find("\nstretch      1.1") != std::string::npos);
  CHECK(table.find(" at most; forces can have given ") != std::string::npos);
}

TEST_CASE("run says how far rods are off, and whether what they alone join heats") {
  const ScratchFolder folder("rods");
  folder.write("pendulum.json", R"({"format": "dvdx-scene/1", "name": "pendulum", "step": 0.01, "duration": 1,
    "particles": {"count": 3, "mass": 1, "position": {"values": [[0, 0, 0], [1, 0, 0], [1, 5, 0]]}}, "fixed": [0],
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "constraints": [{"type": "point", "particle": 2, "at": [1, 5, 0]}, {"type": "distance", "pairs": [[0, 1]], "length": 1}]})");
  const json report = report_of(folder, "pendulum.json");
  CHECK(report["heating"] == false);
  CHECK(report["stretch"].is_null());
  CHECK(report["rods"]["constraint"] == 1);
  CHECK(report["rods"]["between"] == json({0, 1}));
  CHECK(report["rods"]["most"].get<double>() < 1e-5);
  CHECK(report["warnings"] == json::array());
  // A rod that begins too long is off by that at the start.
  const json wrong = report_of(folder, "pendulum.json --set constraints[1].length=0.8");
  CHECK(wrong["rods"]["most"].get<double>() == doctest::Approx(0.25));
  CHECK(wrong["rods"]["time"] == 0);
  REQUIRE(wrong["warnings"].size() >= 1);
  CHECK(wrong["warnings"][0]["code"] == "rods");
  CHECK(run(folder, "run pendulum.json --strict --set constraints[1].length=0.8").exit == 6);
}

// 100 kg on 20 springs of 1e6 N/m, one sweep to and fro of extended position-based dynamics: they would go on for metres.
TEST_CASE("run warns of springs that hold more than there is, and the cure that it names helps") {
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
  CHECK(report_of(folder, "rope.json")["warnings"] == json::array());  // lines of springs hold at one sub-step
}

TEST_CASE("run of a scene that nothing joins says nothing of joints") {
  const ScratchFolder folder("unjoined");
  folder.write("fall.json", R"({"format": "dvdx-scene/1", "name": "fall", "step": 0.01, "duration": 0.1,
    "particles": {"count": 2, "mass": 1}, "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]})");
  const json report = report_of(folder, "fall.json");
  for (const char* key : {"stretch", "rods", "heating", "warnings"}) CHECK(!report.contains(key));
  CHECK(!report["energy"].contains("most"));
}

TEST_CASE("springs and rods as long as at the start, of places that a file gives") {
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

}  // namespace joins_test
