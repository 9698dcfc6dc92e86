// The contacts that `dvdx run` reports: sums in --json, impacts in --events.
#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "support/close.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace contacts_test {

using dvdx::test::is_close;
using dvdx::test::run;
using dvdx::test::ScratchFolder;
using nlohmann::json;

// A resting ball, a bouncing one, and many that fall on both contacts.
constexpr const char* balls = R"({
  "format": "dvdx-scene/1", "name": "balls", "step": 0.0125, "duration": 1,
  "particles": {"count": 2, "mass": 2, "position": {"values": [[0, 0, 0], [3, 1, 0]]}},
  "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
  "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "restitution": 0.5},
               {"type": "sphere", "center": [50, 0, 0], "radius": 1}]
})";
constexpr const char* rain = R"({
  "format": "dvdx-scene/1", "name": "rain", "step": 0.0125, "duration": 1,
  "particles": {"count": 3000, "mass": 0.1, "position": {"uniform": {"min": [-1, 0.5, -1], "max": [1, 2, 1], "seed": 3}}},
  "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}, {"type": "drag", "coefficient": 0.02}],
  "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "restitution": 0.5, "friction": 0.3},
               {"type": "sphere", "center": [0, 0.1, 0], "radius": 0.6, "restitution": 0.7}]
})";

class Folder : public ScratchFolder {
 public:
  explicit Folder(const std::string& name) : ScratchFolder("contacts-" + name) {
    write("balls.json", balls);
    write("rain.json", rain);
  }
};

json contacts_of(const Folder& folder, const std::string& arguments) {
  const auto result = run(folder, "run " + arguments + " --json");
  CAPTURE(result.err);
  REQUIRE(result.exit == 0);
  return json::parse(result.out)["contacts"];
}

std::vector<std::vector<double>> rows_of(const std::string& text, std::string& header) {
  std::istringstream lines(text);
  std::getline(lines, header);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream numbers(line);
    auto& row = rows.emplace_back();
    for (std::string number; std::getline(numbers, number, ',');) row.push_back(std::stod(number));
  }
  return rows;
}

TEST_CASE("run --json reports the hits, the impulse and the torque impulse of each contact") {
  const Folder folder("sums");
  const auto contacts = contacts_of(folder, "balls.json --precision float64");
  REQUIRE(contacts.size() == 2);
  // The impulse is gravity's over a second, less the momentum that the second ball still has.
  CHECK(contacts[0]["hits"].get<int>() >= 2);
  CHECK(contacts[0]["impulse"].size() == 3);
  const double weight = 2 * 9.81;
  const double down = -contacts[0]["impulse"][1].get<double>();
  CHECK(down > 1.5 * weight);
  CHECK(down < 2.5 * weight);
  // The first ball lies at the origin, so the torque is that of the second one, 3 m away.
  CHECK(is_close(-contacts[0]["torque_impulse"][2].get<double>(), 3 * (down - weight), 1e-12));
  CHECK(contacts[1] == json::parse(R"({"hits": 0, "impulse": [0.0, 0.0, 0.0], "torque_impulse": [0.0, 0.0, 0.0]})"));
}

TEST_CASE("run --events writes each impact as in the closed form, and no rows for a resting ball") {
  const Folder folder("events");
  REQUIRE(run(folder, "run balls.json --precision float64 --events e.csv").exit == 0);
  std::string header;
  const auto rows = rows_of(folder.read("e.csv"), header);
  CHECK(header == "step,time,particle,contact,x,y,z,nx,ny,nz,impulse");
  REQUIRE(rows.size() >= 2);
  const double first = std::sqrt(2 / 9.81);
  for (std::size_t n = 0; n < 2; ++n) {
    const double time = first * (n == 0 ? 1 : 2);
    const double speed = 9.81 * first * (n == 0 ? 1 : 0.5);
    CHECK(rows[n][0] == std::ceil(time / 0.0125));
    CHECK(is_close(rows[n][1], time, 1e-12));
    CHECK(rows[n][2] == 1);
    CHECK(rows[n][3] == 0);
    CHECK(rows[n][4] == 3);
    CHECK(std::abs(rows[n][5]) < 1e-12);
    CHECK(rows[n][8] == 1);
    CHECK(is_close(rows[n][10], 2 * 1.5 * speed, 1e-12));
  }
  CHECK(folder.entries() == 3);
}

TEST_CASE("contact sums and events do not depend on layout, threads or instruction set, and leave the state unchanged") {
  const Folder folder("same");
  for (const std::string precision : {"float32", "float64"}) {
    const std::string scene = "rain.json --precision " + precision;
    const auto plain = json::parse(run(folder, "run " + scene + " --json --isa reference").out);
    std::string sums, events;
    for (const char* how :
         {"--isa reference --threads 1", "--threads 2 --layout aosoa", "--threads 1 --layout aos --every 7 --out s.csv"}) {
      CAPTURE(how);
      const auto result = run(folder, "run " + scene + " --json --events e.csv " + how);
      REQUIRE(result.exit == 0);
      const auto report = json::parse(result.out);
      CHECK(report["state_hash"] == plain["state_hash"]);
      CHECK(report["contacts"] == plain["contacts"]);
      if (events.empty()) events = folder.read("e.csv");
      CHECK(folder.read("e.csv") == events);
    }
    std::string header;
    const auto rows = rows_of(events, header);
    CHECK(rows.size() == plain["contacts"][0]["hits"].get<std::size_t>() + plain["contacts"][1]["hits"].get<std::size_t>());
    CHECK(rows.size() > 3000);
  }
}

TEST_CASE("--events writes a .csv of its own, whole or not at all") {
  const Folder folder("refused");
  folder.write("points.csv", "x,y,z\n0,1,0\n");
  folder.write("from.json", R"({"format": "dvdx-scene/1", "name": "f", "step": 0.1, "duration": 1,
    "particles": {"count": 1, "position": {"file": "points.csv"}}, "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0}]})");
  CHECK(run(folder, "run balls.json --events e.txt").exit == 2);
  CHECK(run(folder, "run balls.json --events a.csv --out a.csv").exit == 2);
  const auto source = run(folder, "run from.json --events points.csv");
  CHECK(source.exit == 2);
  CHECK(source.err.find("--events points.csv: ") != std::string::npos);
  CHECK(run(folder, "run balls.json --events missing/e.csv").exit == 4);
  CHECK(folder.entries() == 4);
  // Without contacts the file has only its header.
  CHECK(run(folder, "run from.json --set contacts=[] --events e.csv").exit == 0);
  CHECK(folder.read("e.csv") == "step,time,particle,contact,x,y,z,nx,ny,nz,impulse\n");
}

}  // namespace contacts_test
