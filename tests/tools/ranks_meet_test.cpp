// Particles that meet on several ranks: the bits and impacts of one rank.
#include <doctest/doctest.h>

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "support/paths.hpp"
#include "tools/ranks.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace ranks::meet_test {

// A sheet that is released on its edge and folds onto itself.
std::string folding() {
  return R"({"format": "dvdx-scene/1", "name": "folding", "step": 0.0166666666666666666, "duration": 0.4,
    "network": {"type": "grid", "rows": 24, "columns": 9, "origin": [0, 0.24, 0], "edge_u": [0.08, 0, 0], "edge_v": [0, -0.23, 0.02],
                "mass": 0.02, "structural": 60, "shear": 20, "bend": 2, "damping": 0.001, "scheme": "leapfrog"},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "friction": 0.5}],
    "meet": {"thickness": 0.0095, "friction": 0.3, "most_neighbours": 48}})";
}

TEST_CASE("ranks: particles that meet have the bits and impacts of one rank, and send what explain predicts" *
          doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-meet");
  folder.write("grains.json", grains());
  folder.write("folding.json", folding());
  std::size_t turn = 0;
  for (const std::string& scene :
       {std::string("grains.json"), std::string("folding.json"), std::string("grains.json --precision float32_compensated"),
        "'" + dvdx::test::scenes() + "/heap.json' --duration 0.2 --precision float64",
        "'" + dvdx::test::scenes() + "/layers.json' --duration 0.25 --set network[0].lines=none --set network[1].lines=none"}) {
    CAPTURE(scene);
    const std::string arguments = "run " + scene + " --json --every 7 --threads 1";
    const auto alone = said(run(folder, arguments + " --out a.csv --events a-events.csv"));
    CHECK(alone["meet"]["pairs"] > 0);
    CHECK(alone["meet"]["overlap"]["most"] > 0);
    for (const int ranks : ranks_of(turn++)) {
      CAPTURE(ranks);
      const auto result = run_on(ranks, folder, arguments + " --out b.csv --events b-events.csv");
      CHECK(said(result) == alone);
      CHECK(folder.read("b.csv") == folder.read("a.csv"));
      CHECK(folder.read("b-events.csv") == folder.read("a-events.csv"));
      if (scene.find("layers") != std::string::npos) continue;  // it has fewer sheets than ranks
      const auto report = nlohmann::json::parse(result.out);
      const auto [bytes, messages] = predicted(folder, scene, ranks);
      const auto substeps = report["steps"].get<std::uint64_t>() * report["substeps"].get<std::uint64_t>();
      CHECK(report["halo"]["bytes"] == substeps * bytes);
      CHECK(report["halo"]["messages"] == substeps * messages);
    }
  }
}

TEST_CASE("ranks: some ranks may have no particles that meet, and too many neighbours end all ranks at once" *
          doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-crowd");
  folder.write("few.json", grains(3));
  const std::string arguments = "run few.json --json --threads 1";
  CHECK(said(run_on(5, folder, arguments)) == said(run(folder, arguments)));
  folder.write("grains.json", grains());
  const auto refused = run_on(3, folder, "run grains.json --set meet.most_neighbours=2 --out a.csv");
  CHECK(refused.exit == 3);
  CHECK_MESSAGE(times(refused.err, "meet.most_neighbours is 2, and between") == 1, refused.err);
  CHECK_FALSE(std::filesystem::exists(folder / "a.csv"));
}

}  // namespace ranks::meet_test
