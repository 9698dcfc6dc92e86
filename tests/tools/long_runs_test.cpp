// Rounding over many steps: energy and phase compared with the random walk that theory predicts.
#include "hard_cases/long_runs.hpp"

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

namespace long_runs_test {

using namespace dvdx::tool;
using stability::LongRun;

TEST_CASE("long runs: float32's energy walks as theory says, and compensated states keep phase and energy ten times better") {
  constexpr std::uint64_t steps = 100000;
  const auto runs = stability::measure_long_runs(steps, [](std::size_t) {});
  REQUIRE(runs.size() == 3 * 3 * 4);
  for (const LongRun& run : runs) {
    CAPTURE(run.z);
    CAPTURE(run.steps);
    CAPTURE(static_cast<int>(run.precision));
    CHECK(run.energy > 0);
    if (run.precision == Precision::float32) {
      CHECK(run.energy < 5 * run.walk);
      if (run.steps == steps) CHECK(run.energy > run.walk / 20);
    }
    if (run.precision == Precision::float32_compensated) {
      const auto plain = &run - 8;  // float64 and float32 precede it with four rows each
      REQUIRE(plain->precision == Precision::float32);
      CHECK(10 * run.phase < plain->phase);
      CHECK(10 * run.energy < plain->energy);
    }
  }
  const auto json = stability::to_json(runs);
  CHECK(json.size() == runs.size());
  CHECK(json[0].contains("phase_walk"));
  CHECK(stability::to_text(runs).find("float32_compensated") != std::string::npos);
}

}  // namespace long_runs_test
