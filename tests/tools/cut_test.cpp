// The distribution of particles over ranks, by counting: formulas compared with lists, and the gain by METIS.
#include "ranks/cut.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "scale/prediction.hpp"
#include "support/close.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace cut_test {

using namespace dvdx;
using namespace dvdx::tool;

void check_alike(const Cut& a, const Cut& b) {
  CHECK(a.particles == b.particles);
  CHECK(a.fewest == b.fewest);
  CHECK(a.springs == b.springs);
  CHECK(a.halo == b.halo);
  CHECK(a.neighbours == b.neighbours);
  CHECK(a.all_particles == b.all_particles);
  CHECK(a.all_springs == b.all_springs);
  CHECK(a.cut_springs == b.cut_springs);
  CHECK(a.all_halo == b.all_halo);
  CHECK(a.all_neighbours == b.all_neighbours);
}

TEST_CASE("a sheet cut by formula into rows and columns has the same counts as its list of springs") {
  std::mt19937 random(1);
  const auto below = [&](std::size_t end) { return random() % end; };
  for (int n = 0; n < 150; ++n) {
    Grid grid{.rows = 2 + below(40), .columns = 2 + below(40), .edge_u = {1, 0, 0}, .edge_v = {0, 1, 0}};
    grid.structural = 10;
    grid.shear = below(2) == 0 ? 0 : 3;
    grid.bend = below(2) == 0 ? 0 : 1;
    const std::uint64_t rows = 1 + below(std::min<std::size_t>(grid.rows, 9));
    const std::uint64_t columns = 1 + below(std::min<std::size_t>(grid.columns, 7));
    CAPTURE(grid.rows);
    CAPTURE(grid.columns);
    CAPTURE(rows);
    CAPTURE(columns);
    std::vector<std::uint32_t> owner;
    for (std::size_t i = 0; i < grid.rows * grid.columns; ++i) {
      const auto row = i / grid.columns * rows / grid.rows;
      owner.push_back(static_cast<std::uint32_t>(row * columns + i % grid.columns * columns / grid.columns));
    }
    check_alike(cut_of_sheet(grid, rows, columns), cut_of_pairs(dvdx::springs_of(grid).pairs, owner, rows * columns));
  }
}

TEST_CASE("unjoined particles are shared out evenly and send nothing") {
  const Cut cut = cut_of_ranges(10, 3);
  CHECK(cut.particles == 4);
  CHECK(cut.fewest == 3);
  CHECK(dvdx::test::is_close(cut.imbalance(), 1.2, 1e-12));
  CHECK(cut.halo + cut.neighbours + cut.cut_springs == 0);
  CHECK(times_of(cut, {.times = 1, .numbers = 3, .bytes = 4}, {.particle_seconds = 2.0}).all() == 8);
}

TEST_CASE("the best blocks cut the fewest springs") {
  Grid grid{.rows = 100, .columns = 400, .structural = 1};
  CHECK(best_blocks(grid, 4) == std::array<std::uint64_t, 2>{1, 4});
  CHECK(best_blocks(grid, 16) == std::array<std::uint64_t, 2>{2, 8});
  CHECK(!best_blocks(grid, 499).has_value());  // a prime larger than either side
}

TEST_CASE("METIS cuts a randomly numbered sheet evenly, and far fewer springs than its numbering does") {
  Grid grid{.rows = 40, .columns = 40, .structural = 1};
  auto pairs = dvdx::springs_of(grid).pairs;
  std::vector<std::uint32_t> number(1600);
  for (std::uint32_t i = 0; i < 1600; ++i) number[i] = i;
  std::shuffle(number.begin(), number.end(), std::mt19937(2));
  for (auto& [a, b] : pairs) {
    a = number[a];
    b = number[b];
  }
  const auto owner = owners_by_metis(pairs, 1600, 8);
  if (!owner) return;  // built without METIS
  std::vector<std::uint32_t> by_number(1600);
  for (std::uint32_t i = 0; i < 1600; ++i) by_number[i] = i / 200;
  const Cut metis = cut_of_pairs(pairs, *owner, 8), numbers = cut_of_pairs(pairs, by_number, 8);
  CHECK(metis.cut_springs < numbers.cut_springs / 8);
  CHECK(metis.imbalance() < 1.05);
  CHECK(metis.fewest > 0);
}

TEST_CASE("a sheet of a thousand million particles is counted at once, and so is one a thousand times as large") {
  Grid grid{.rows = 32768, .columns = 32768, .structural = 1, .shear = 1};
  const Cut cut = cut_of_sheet(grid, 32, 32);
  CHECK(cut.particles == 1024 * 1024);
  CHECK(cut.halo == 4 * 1024 + 4);
  CHECK(cut.neighbours == 8);
  CHECK(cut.imbalance() == 1);
  grid.rows *= 32;
  grid.columns *= 32;
  CHECK(cut_of_sheet(grid, 512, 256).all_particles == std::uint64_t{1} << 40U);
}

TEST_CASE("explain --ranks reports the cut, and predicts the time from the given latency and bandwidth") {
  const dvdx::test::ScratchFolder folder("explain-ranks");
  folder.write("sheet.json",
               R"({"format": "dvdx-scene/1", "name": "sheet", "step": 0.01, "duration": 1, "network": {"type": "grid",
    "rows": 8, "columns": 10, "origin": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1], "mass": 1, "structural": 10}})");
  const auto result = dvdx::test::run(
      folder, "explain sheet.json --ranks 4 --latency 1e-6 --bandwidth 1e9 --particle-time 1e-7 --precision float64");
  CHECK(result.exit == 0);
  const auto says = [&](const char* text) {
    CAPTURE(text);
    CAPTURE(result.out);
    CHECK(result.out.find(text) != std::string::npos);
  };
  says("shared by stripes\n  particles a rank       20 at most, 20 at least; imbalance 1.0000\n");
  says("cut                    30 of 142 springs, 21.1 %");
  says("told a sub-step        480 bytes in 2 messages to a rank at most; 1440 bytes in 6 over all ranks");
  says("predicted sub-step     4.48e-06 s: 2e-06 s of particles, 2.48e-06 s of messages");
  says("predicted efficiency   0.446");
  says("shared by blocks");
  const auto large = dvdx::test::run(folder, "explain sheet.json --ranks 3 --size 3072x1024 --particle-time 1e-9");
  CHECK(large.out.find("told a sub-step        49152 bytes in 1 messages to a rank at most; 98304 bytes in 2 over all ranks\n"
                       "                         4 sub-steps at a time, of a halo so many times as deep\n") !=
        std::string::npos);
  CHECK(dvdx::test::run(folder, "explain sheet.json --ranks 81").exit == 2);
  CHECK(dvdx::test::run(folder, "explain sheet.json --ranks 4 --size 1e6").exit == 2);
  CHECK(dvdx::test::run(folder, "explain sheet.json --latency 1").exit == 2);
  CHECK(dvdx::test::run(folder, "explain sheet.json --ranks 1024 --size 4096x4096 --particle-time 1e-9").exit == 0);
}

}  // namespace cut_test
