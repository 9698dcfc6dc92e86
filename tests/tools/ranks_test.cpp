// One scene on several ranks: the same bits, the same files, the same refusals as on one.
#include <doctest/doctest.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "support/paths.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace {

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

// What a run says that must not depend on the ranks.
nlohmann::json said(const CommandResult& result) {
  CHECK_MESSAGE(result.exit == 0, result.err);
  auto report = nlohmann::json::parse(result.out, nullptr, false);
  REQUIRE_FALSE(report.is_discarded());
  for (const char* key : {"wall_seconds", "particle_steps_per_second", "threads", "ranks"}) report.erase(key);
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

}  // namespace

TEST_CASE("ranks: particles that nothing joins have the bits of one rank" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("bits");
  for (const char* precision : {"float32", "float64", "float32_compensated"}) {
    const std::string arguments = std::string("run mixed.json --json --threads 1 --precision ") + precision;
    const auto alone = said(run(folder, arguments));
    for (const int ranks : {2, 3, 5}) {
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
  folder.write("sheet.json", R"({"format": "dvdx-scene/1", "name": "sheet", "step": 0.01, "duration": 0.05,
    "network": {"type": "grid", "rows": 9, "columns": 7, "origin": [0, 1, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0.3, 1], "mass": 0.2,
                "structural": 40, "shear": 20, "bend": 5, "fixed": ["corners_top"]},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}, {"type": "drag", "coefficient": 0.001}],
    "contacts": [{"type": "sphere", "center": [0.5, 0.9, 0.5], "radius": 0.2, "friction": 0.3}]})");
  // Numbers as they come, two springs between two particles, and a particle that none holds.
  folder.write("list.json", R"({"format": "dvdx-scene/1", "name": "list", "step": 0.01, "duration": 0.05,
    "particles": {"count": 12, "mass": {"uniform": {"min": 0.1, "max": 0.3, "seed": 4}},
                  "position": {"uniform": {"min": [0, 0, 0], "max": [1, 1, 1], "seed": 3}}},
    "network": [{"type": "springs", "pairs": [[0, 7], [7, 3], [3, 9], [9, 1], [1, 10], [10, 4], [4, 7], [3, 7]], "stiffness": 30,
                 "rest_length": 0.4, "damping": 0.02},
                {"type": "springs", "pairs": [[4, 8], [8, 2], [2, 5], [5, 0], [5, 11], [11, 0]], "stiffness": 30, "rest_length": "start"}],
    "fixed": [1], "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]})");
  for (const char* run_of : {"sheet.json", "sheet.json --set network.bend=0 --set network.damping=0.01 --precision float64",
                             "list.json", "list.json --scheme fourth_order --precision float32_compensated"}) {
    CAPTURE(run_of);
    const std::string arguments = std::string("run ") + run_of + " --json --threads 1";
    const auto alone = said(run(folder, arguments));
    for (const int ranks : {2, 3, 5}) {
      CAPTURE(ranks);
      CHECK(said(run_on(ranks, folder, arguments)) == alone);
    }
  }
}

TEST_CASE("ranks: every file has the bytes of one rank's" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("files");
  for (const std::string kind : {"csv", "npz", "ply", "pc2", "vtp"}) {
    CAPTURE(kind);
    const std::string arguments = "run mixed.json --every 7 --out ";
    std::filesystem::create_directory(folder / kind);
    REQUIRE(run(folder, arguments + kind + "/all." + kind).exit == 0);
    const ScratchFolder parts("ranks-parts");
    const auto result = run_on(kind == "csv" ? 2 : 3, folder, arguments + (parts / "all.") + kind);
    CHECK_MESSAGE(result.exit == 0, result.err);
    CHECK(parts.entries() > 0);
    for (const auto& entry : std::filesystem::directory_iterator(folder / kind)) {
      const auto name = entry.path().filename().string();
      CHECK(folder.read(kind + "/" + name) == parts.read(name));
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
  check("--set 'network={\"type\":\"springs\",\"pairs\":[[0,1]],\"stiffness\":1,\"rest_length\":1,\"scheme\":\"sequential\"}'",
        3, "network.scheme sequential cannot be split over ranks");
  check("--set 'constraints=[{\"type\":\"distance\",\"pairs\":[[0,1]],\"length\":1}]'", 3, "constraints cannot be split");
}

TEST_CASE("ranks: one that is killed ends the others, and nothing is half written" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("killed");
  const auto start = std::chrono::steady_clock::now();
  // Once all of them run, one is killed: the launcher is their parent.
  folder.write("kill.sh", R"("$@" & launcher=$!
for n in $(seq 200); do
  sleep 0.1
  ranks=$(pgrep -P $launcher -x dvdx)
  [ $n -gt 10 ] && [ $(echo $ranks | wc -w) -eq 3 ] && break
done
kill -9 ${ranks##* }
wait $launcher)");
  const auto result = run(folder, "run mixed.json --duration 2e6 --every 1000 --out all.csv", launcher(3, "sh kill.sh"));
  CHECK(result.exit != 0);
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(60));
  CHECK_FALSE(std::filesystem::exists(folder / "all.csv"));
}
