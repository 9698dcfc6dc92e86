// dvdx run: the states that it writes.
#include <doctest/doctest.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tools/command_folders.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace command_folders::states_test {

using dvdx::test::run;
using nlohmann::json;

TEST_CASE("states are written at step 0, every N steps and at the end") {
  const Folder folder("every");
  const auto steps_written = [&](const std::string& options) {
    REQUIRE(run(folder, "run fall.json --out a.csv " + options).exit == 0);
    std::vector<std::string> steps;
    std::istringstream rows(folder.read("a.csv"));
    for (std::string row; std::getline(rows, row);) {
      const auto step = row.substr(0, row.find(','));
      if (step != "step" && (steps.empty() || steps.back() != step)) steps.push_back(step);
    }
    return steps;
  };
  using Steps = std::vector<std::string>;
  CHECK(steps_written("") == Steps{"10"});
  CHECK(steps_written("--every 0") == Steps{"10"});
  CHECK(steps_written("--every 4") == Steps{"0", "4", "8", "10"});
  CHECK(steps_written("--every 5") == Steps{"0", "5", "10"});
  CHECK(steps_written("--every 100") == Steps{"0", "10"});
  CHECK(steps_written("--every 1 --duration 0") == Steps{"0"});
  CHECK(steps_written("--fps 2") == Steps{"0", "4", "8", "10"});  // at 8 steps a second
  CHECK(steps_written("--fps 3") == Steps{"0", "3", "5", "8", "10"});
  CHECK(steps_written("--fps 1000 --duration 0.25") == Steps{"0", "1", "2"});
}

TEST_CASE("a run reports its files: formats that are played have 30 states a second, all others the last state") {
  const Folder folder("written");
  const auto written = [&](const std::string& options) {
    const auto result = run(folder, "run fall.json --step 0.0078125 " + options);  // 160 steps of 1/128 s
    REQUIRE(result.exit == 0);
    const auto at = result.out.find("written      ");
    return at == std::string::npos ? "nothing" : result.out.substr(at + 13, result.out.find('\n', at) - at - 13);
  };
  CHECK(written("") == "nothing");
  CHECK(written("--out a.csv") == "a.csv (the last state)");
  CHECK(written("--out a.csv --events e.csv") == "a.csv (the last state), e.csv");
  CHECK(written("--out a.npz") == "a.npz (39 frames)");  // 0, 1/30, ..., 37/30 and 1.25 s
  CHECK(written("--out a.npz --every 0") == "a.npz (the last state)");
  CHECK(written("--out a.pc2") == "a.pc2 (39 frames), a.obj");
  CHECK(written("--out a.ply --every 80") == "a-000000.ply to a-000002.ply (3 frames)");
  CHECK(written("--out a.vtp --fps 1") == "a-000000.vtp to a-000002.vtp (3 frames), a.pvd");
  CHECK(written("--out b.obj") == "b.obj (the last state)");
  CHECK(written("--out b.obj --every 160") == "b-000000.obj to b-000001.obj (2 frames)");
  CHECK(written("--out b.png") == "b.png (the last state)");
  CHECK(written("--out b.apng --fps 4") == "b.apng (6 frames)");
  for (const char* file : {"a.csv", "e.csv", "a.npz", "a.pc2", "a.obj", "a-000002.ply", "a-000002.vtp", "a.pvd", "b.obj",
                           "b-000001.obj", "b.png", "b.apng"}) {
    CAPTURE(file);
    CHECK_FALSE(folder.read(file).empty());
  }
  const auto report = json::parse(run(folder, "run fall.json --json --out a.pc2 --every 5").out);
  CHECK(report["written"] == json::parse(R"([{"file": "a.pc2", "frames": 3}, {"file": "a.obj"}])"));
}

TEST_CASE("an .obj is the last state, with the faces of its sheets") {
  const ScratchFolder folder("command-obj");
  folder.write("square.json", R"({"format": "dvdx-scene/1", "name": "square", "step": 0.5, "duration": 1,
    "network": {"type": "grid", "rows": 2, "columns": 2, "origin": [0, 1, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1],
                "mass": 1, "structural": 1}, "forces": [{"type": "constant", "acceleration": [0, -2, 0]}]})");
  REQUIRE(run(folder, "run square.json --out a.obj --precision float64").exit == 0);
  const auto text = folder.read("a.obj");
  CHECK(text.starts_with("# dvdx: step 2, 1 s\nv 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\nf "));  // 1 - 2 t^2 / 2
  CHECK(run(folder, "run square.json --set network.type=mesh --set network.file=a.obj --out a.obj").exit != 0);
  CHECK(folder.read("a.obj") == text);
}

TEST_CASE("every format is written whole") {
  const Folder folder("formats");
  CHECK(run(folder, "run fall.json --every 5 --out a.npz").exit == 0);
  CHECK(run(folder, "run fall.json --every 5 --out b.ply --precision float64").exit == 0);
  CHECK(run(folder, "run fall.json --every 5 --out c.vtp").exit == 0);
  CHECK(run(folder, "run fall.json --every 5 --out d.pc2").exit == 0);
  CHECK(folder.entries() == 1 + 1 + 3 + 4 + 2);
}

TEST_CASE("a grid's faces stand in the .obj beside its .pc2") {
  const SheetFolder folder("sheet-out");
  CHECK(run(folder, "run sheet.json --out sheet.pc2").exit == 0);
  CHECK(folder.read("sheet.obj").find("\nf 1 2 8 7\n") != std::string::npos);
}

TEST_CASE("where a sheet tears, the files of later states have fewer faces") {
  const ScratchFolder folder("command-tear");
  folder.write("tear.json", R"({"format": "dvdx-scene/1", "name": "tear", "step": 0.005, "duration": 0.5,
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "network": {"type": "grid", "rows": 6, "columns": 6, "origin": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, -1, 0],
                "mass": 0.036, "structural": 20, "fixed": ["edge_top"], "tears_at": 1.02}})");
  const auto result = run(folder, "run tear.json --json --out sheet.vtp --every 50");
  REQUIRE(result.exit == 0);
  CHECK(json::parse(result.out)["torn"] == 6);  // a whole row
  CHECK(folder.read("sheet-000000.vtp").find("NumberOfPolys=\"25\"") != std::string::npos);
  CHECK(folder.read("sheet-000002.vtp").find("NumberOfPolys=\"20\"") != std::string::npos);
  CHECK(run(folder, "run tear.json --out sheet.ply --every 50").exit == 0);
  CHECK(folder.read("sheet-000000.ply").find("element face 25\n") != std::string::npos);
  CHECK(folder.read("sheet-000002.ply").find("element face 20\n") != std::string::npos);
  CHECK(run(folder, "run tear.json --out sheet.obj").exit == 0);  // the last state
  const std::string obj = folder.read("sheet.obj");
  std::size_t faces = 0;
  for (std::size_t at = 0; (at = obj.find("\nf ", at)) != std::string::npos; ++at) ++faces;
  CHECK(faces == 20);

  // Springs are torn in the first state in which they are too long: 0.204 m, from the first row to the second.
  CHECK(run(folder, "run tear.json --out each.vtp --every 1").exit == 0);
  CHECK(run(folder, "run tear.json --out each.csv --every 1").exit == 0);
  std::istringstream lines(folder.read("each.csv"));
  std::string line;
  int torn_at = -1;
  while (torn_at < 0 && std::getline(lines, line)) {
    int step = 0, particle = 0;
    double y = 0;
    const bool is_state = std::sscanf(line.c_str(), "%d,%*f,%d,%*f,%lf", &step, &particle, &y) == 3;
    if (is_state && particle == 6 && y < -0.204) torn_at = step;
  }
  REQUIRE(torn_at > 0);
  const auto faces_of = [&](int step) {
    const std::string number = std::to_string(step);
    const std::string text = folder.read("each-" + std::string(6 - number.size(), '0') + number + ".vtp");
    return text.substr(text.find("NumberOfPolys"), 18);
  };
  CHECK(faces_of(torn_at - 1) == "NumberOfPolys=\"25\"");
  CHECK(faces_of(torn_at) == "NumberOfPolys=\"20\"");
}

}  // namespace command_folders::states_test
