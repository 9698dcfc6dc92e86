#include "work/tiles.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "support/threads.hpp"

namespace dvdx::test::tiles_test {

// The number of stages each chunk has completed, and whether each found its neighbours in a readable stage.
struct Progress {
  explicit Progress(std::size_t chunks) : stage(chunks, 0) {}

  void take(std::size_t j, std::size_t from, std::size_t to) {
    for (std::size_t c = from; c < to; ++c) {
      is_in_turn = is_in_turn && stage[c] == j;
      for (std::size_t n = c - std::min<std::size_t>(c, 1); n <= std::min(c + 1, stage.size() - 1); ++n) {
        is_in_turn = is_in_turn && (stage[n] == j || stage[n] == j + 1);
      }
      stage[c] = j + 1;
    }
  }

  std::vector<std::size_t> stage;
  bool is_in_turn = true;
};

TEST_CASE("tiles: every chunk goes through all stages, each beside neighbours that are level with it or one ahead") {
  for (const std::size_t per_block : {2U, 5U, 8U, 18U}) {
    for (std::size_t stages = 1; stages <= per_block / 2; ++stages) {
      for (const std::size_t chunks : {1U, 2U, 7U, 16U, 17U, 100U}) {
        Progress progress(chunks);
        for_each_tile(ParallelFor{}, chunks, per_block, stages,
                      [&](std::size_t j, std::size_t from, std::size_t to) { progress.take(j, from, to); });
        CHECK(progress.is_in_turn);
        CHECK(std::all_of(progress.stage.begin(), progress.stage.end(), [&](std::size_t s) { return s == stages; }));
      }
    }
  }
}

TEST_CASE("tiles: with threads all stages together are two loops") {
  test::Threads threads(3);
  std::vector<std::size_t> stage(64, 0);
  for_each_tile(threads.parallel_for(), 64, 16, 8, [&](std::size_t j, std::size_t from, std::size_t to) {
    for (std::size_t c = from; c < to; ++c) stage[c] = j + 1;
  });
  CHECK(threads.calls() == 2);
  CHECK(std::all_of(stage.begin(), stage.end(), [](std::size_t s) { return s == 8; }));
}

}  // namespace dvdx::test::tiles_test
