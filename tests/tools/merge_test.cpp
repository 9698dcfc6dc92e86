// A sweep by plain processes with its reports in one table, and a scene that resumes by itself after a kill.
#include <doctest/doctest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "support/paths.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace merge_test {

using dvdx::test::run;
using dvdx::test::ScratchFolder;

constexpr const char* scene = R"({"format": "dvdx-scene/1", "name": "fall, \"slow\"", "step": 0.125, "duration": 2,
  "particles": {"count": 3, "position": {"uniform": {"min": [0, 1, 0], "max": [1, 2, 1], "seed": 1}}},
  "forces": [{"type": "constant", "acceleration": [0, -8, 0]}]})";

std::string script(const char* name) { return dvdx::test::scenes() + "/../slurm/" + name; }

// Returns a shell's exit code. DVDX names the tested command.
int shell(const ScratchFolder& folder, const std::string& line) {
  const std::string all =
      "cd '" + folder.path().string() + "' && DVDX='" + dvdx::test::command() + "' " + line + " > /dev/null 2>&1 < /dev/null";
  return WEXITSTATUS(std::system(all.c_str()));
}

TEST_CASE("a sweep writes a report for each line, keeps existing reports, and merges into one table") {
  const ScratchFolder folder("sweep");
  folder.write("fall.json", scene);
  folder.write("values.txt", "--seed 1\n--seed 2 --set forces[0].acceleration=[0,-1,0]\n--duration 1\n");
  REQUIRE(shell(folder, script("sweep.sh") + " fall.json values.txt reports") == 0);
  const auto csv = run(folder, "merge reports/1.json reports/2.json reports/3.json");
  CHECK(csv.exit == 0);
  CHECK(csv.out.starts_with("report,scene,particles,steps,"));
  CHECK(csv.out.find("\nreports/2.json,\"fall, \"\"slow\"\"\",3,16,") != std::string::npos);
  CHECK(csv.out.find(",energy.start,energy.end,") != std::string::npos);
  const auto all = nlohmann::json::parse(run(folder, "merge --json reports/1.json reports/3.json").out);
  REQUIRE(all.size() == 2);
  CHECK(all[0]["steps"] == 16);
  CHECK(all[1]["steps"] == 8);
  CHECK(all[0]["energy.start"] == all[0]["energy.start"]);

  const auto before = folder.read("reports/1.json");
  folder.write("values.txt", "--seed 3\n--seed 2\n--duration 1\n--set nothing=1\n");
  CHECK(shell(folder, script("sweep.sh") + " fall.json values.txt reports") == 3);  // only the last line runs, and is refused
  CHECK(folder.read("reports/1.json") == before);
  CHECK(!std::filesystem::exists(folder / "reports/4.json"));
}

TEST_CASE("merge refuses a file that is not a report") {
  const ScratchFolder folder("merge");
  folder.write("fall.json", scene);
  folder.write("text.json", "hello");
  CHECK(run(folder, "merge fall.json").exit == 4);
  CHECK(run(folder, "merge text.json").exit == 4);
  CHECK(run(folder, "merge nowhere.json").exit == 4);
  CHECK(run(folder, "merge").exit == 2);
}

TEST_CASE("a killed scene resumes by itself to the same end") {
  const ScratchFolder folder("farm");
  folder.write("fall.json", scene);
  // Ends itself twice, as kill -9 would, at some step after the first checkpoint.
  folder.write("killed.sh",
               "#!/bin/sh\nif [ $(cat tries | wc -l) -lt 2 ]; then echo x >> tries; \"$REAL\" \"$@\"; kill -9 $$; fi\nexec "
               "\"$REAL\" \"$@\"\n");
  folder.write("tries", "");
  std::filesystem::permissions(folder / "killed.sh", std::filesystem::perms::owner_all);
  const std::string line = "cd '" + folder.path().string() + "' && REAL='" + dvdx::test::command() + "' DVDX=./killed.sh " +
                           script("run_scene.sh") + " fall.json at 5 --out out.csv --every 2 > log 2>&1";
  CHECK(WEXITSTATUS(std::system(line.c_str())) == 0);
  CHECK(folder.read("tries") == "x\nx\n");
  REQUIRE(run(folder, "run fall.json --out whole.csv --every 2").exit == 0);
  CHECK(folder.read("out.csv") == folder.read("whole.csv"));
  CHECK(folder.read("log").find("resumed") != std::string::npos);
  CHECK(shell(folder, script("run_scene.sh") + " nowhere.json at2 5") == 4);  // is not retried
}

}  // namespace merge_test
