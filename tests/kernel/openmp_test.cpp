#if defined(DVDX_TEST_OPENMP)

#include "dvdx/openmp.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

namespace dvdx::test::openmp_test {

using Counts = std::vector<std::atomic<int>>;

void count(void* task, std::size_t index) { ++(*static_cast<Counts*>(task))[index]; }

bool are_all(const Counts& counts, int wanted) {
  return std::all_of(counts.begin(), counts.end(), [&](const std::atomic<int>& n) { return n == wanted; });
}

TEST_CASE("openmp: a team does every task of every loop once" * doctest::test_suite("threads")) {
  for (const int threads : {2, 3, 7}) {
    const OpenMpTeam team(threads);
    const ParallelFor parallel = team.parallel_for();
    for (const std::size_t size : {0U, 1U, 2U, 5U, 64U, 1000U}) {
      Counts counts(size);
      for (int loop = 1; loop <= 200; ++loop) {
        parallel.run(parallel.context, size, count, &counts);
        REQUIRE(are_all(counts, loop));
      }
    }
  }
}

TEST_CASE("openmp: a team that slept goes on") {
  const OpenMpTeam team(3);
  Counts counts(100);
  for (int loop = 1; loop <= 3; ++loop) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    team.parallel_for().run(team.parallel_for().context, counts.size(), count, &counts);
    CHECK(are_all(counts, loop));
  }
}

TEST_CASE("openmp: two callers of one team at once both have their loops done") {
  const OpenMpTeam team(2);
  const auto loops = [&](Counts& counts) {
    for (int loop = 1; loop <= 500; ++loop) {
      team.parallel_for().run(team.parallel_for().context, counts.size(), count, &counts);
      if (!are_all(counts, loop)) return false;
    }
    return true;
  };
  Counts a(50), b(70);
  bool is_right = false;
  std::thread other([&] { is_right = loops(b); });
  CHECK(loops(a));
  other.join();
  CHECK(is_right);
}

// One task waits for the end of another. The thread that runs it must not delay the others' tasks.
TEST_CASE("openmp: the tasks that a held-up thread leaves are done by the others") {
  const OpenMpTeam team(2);
  struct Held {
    std::atomic<int> done{0};
  } held;
  const auto body = [](void* task, std::size_t index) {
    auto& self = *static_cast<Held*>(task);
    while (index == 0 && self.done != 9) std::this_thread::yield();
    ++self.done;
  };
  team.parallel_for().run(team.parallel_for().context, 10, body, &held);
  CHECK(held.done == 10);
}

TEST_CASE("openmp: a team of one hands nothing on") { CHECK((OpenMpTeam(1).parallel_for().run == nullptr)); }

}  // namespace dvdx::test::openmp_test

#endif
