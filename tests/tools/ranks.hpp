// One scene on several ranks: its start, and the results that must not depend on the ranks.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/paths.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace ranks {

using dvdx::test::CommandResult;
using dvdx::test::run;
using dvdx::test::ScratchFolder;

// Allows more ranks than cores, and root in a container. Skips the search for other machines, which takes longest.
inline std::string launcher(int ranks, const std::string& by = "") {
  return "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_plm=isolated OMPI_MCA_pml=ob1 "
         "OMPI_MCA_btl=self,vader " +
         by + " '" + dvdx::test::mpirun() + "' --oversubscribe -n " + std::to_string(ranks);
}

inline CommandResult run_on(int ranks, const ScratchFolder& folder, const std::string& arguments) {
  return run(folder, arguments, launcher(ranks));
}

// Similar runs alternate: one on two ranks, neither of which lies between others, and on five; the next on three.
inline std::vector<int> ranks_of(std::size_t turn) { return turn % 2 == 0 ? std::vector{2, 5} : std::vector{3}; }

// The part of a run's report that must not depend on the ranks.
inline nlohmann::json said(const CommandResult& result) {
  CHECK_MESSAGE(result.exit == 0, result.err);
  auto report = nlohmann::json::parse(result.out, nullptr, false);
  REQUIRE_FALSE(report.is_discarded());
  for (const char* key : {"wall_seconds", "particle_steps_per_second", "threads", "ranks", "halo"}) report.erase(key);
  // Only a single process checks lengths, and what comes through cloth.
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
  // File names are as requested, so they differ.
  if (report.contains("written")) {
    for (auto& file : report["written"]) file.erase("file");
  }
  return report;
}

inline std::size_t times(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++count;
  return count;
}

// Every value differs between particles, and one of 53 is so fast that contacts use the formula for all.
inline std::string mixed() {
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

// 9 rows of 7 particles, hung by two corners over a ball.
inline std::string sheet() {
  return R"({"format": "dvdx-scene/1", "name": "sheet", "step": 0.01, "duration": 0.05,
    "network": {"type": "grid", "rows": 9, "columns": 7, "origin": [0, 1, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0.3, 1], "mass": 0.2,
                "structural": 40, "shear": 20, "bend": 5, "fixed": ["corners_top"]},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}, {"type": "drag", "coefficient": 0.001}],
    "contacts": [{"type": "sphere", "center": [0.5, 0.9, 0.5], "radius": 0.2, "friction": 0.3}]})";
}

// Random pairs, two springs between the same two particles, and a particle without a spring.
inline std::string list() {
  return R"({"format": "dvdx-scene/1", "name": "list", "step": 0.01, "duration": 0.05,
    "particles": {"count": 12, "mass": {"uniform": {"min": 0.1, "max": 0.3, "seed": 4}},
                  "position": {"uniform": {"min": [0, 0, 0], "max": [1, 1, 1], "seed": 3}}},
    "network": [{"type": "springs", "pairs": [[0, 7], [7, 3], [3, 9], [9, 1], [1, 10], [10, 4], [4, 7], [3, 7]], "stiffness": 30,
                 "rest_length": 0.4, "damping": 0.02},
                {"type": "springs", "pairs": [[4, 8], [8, 2], [2, 5], [5, 0], [5, 11], [11, 0]], "stiffness": 30, "rest_length": "start"}],
    "fixed": [1], "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]})";
}

// Balls of two sizes in a hollow sphere over a rising floor, one of them fixed. The first indices lie under the last, so that
// the ranks' ranges meet.
inline std::string grains(int count = 41) {
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

// Drops of two emitters and three initial ones. In the middle of the run some births exceed the capacity.
inline std::string drops() {
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

inline const bool has_no_mpi = dvdx::test::mpirun().empty();

// The line of `explain --ranks` with the exchanges of all ranks in a sub-step: bytes and messages of the least way to send.
inline std::array<std::uint64_t, 2> predicted(const ScratchFolder& folder, const std::string& scene, int ranks) {
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

}  // namespace ranks
