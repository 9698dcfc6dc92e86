// Free particles on several ranks: the bits of one rank.
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scene_io/fault.hpp"
#include "scene_io/scene_reader.hpp"
#include "state/refusal.hpp"
#include "support/paths.hpp"
#include "tools/ranks.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace ranks::particles_test {

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

TEST_CASE("ranks: all shipped scenes but four can be split") {
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
  // Grains that come and go, and particles joined by constraints.
  CHECK(refused == std::vector<std::string>{"cradle", "pour", "ribbon", "towel"});
  CHECK(split >= 25);
}

TEST_CASE("ranks: more ranks than particles, or particles far from home, leave the bits of one rank" *
          doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-far");
  folder.write("far.json", R"({"format": "dvdx-scene/1", "name": "far", "step": 0.01, "duration": 0.1,
    "particles": {"count": 3, "position": {"values": [[0, 0, 0], [5000.25, 0, 0], [5000.25, 1, 0]]}, "velocity": [1, 2, 3]},
    "forces": [{"type": "spring", "stiffness": 2, "anchor": "start"}]})");
  for (const char* more : {"", " --set 'contacts=[{\"type\":\"plane\",\"normal\":[0,1,0],\"offset\":-1}]'"}) {
    const std::string arguments = std::string("run far.json --json --threads 1") + more;
    CHECK(said(run_on(5, folder, arguments)) == said(run(folder, arguments)));
  }
}

}  // namespace ranks::particles_test
