// One undamped spring over ten million steps: the error of energy and phase by rounding, beside the error that theory predicts.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "state/engine.hpp"

namespace dvdx::tool::stability {

inline constexpr std::uint64_t ten_million = 10'000'000;

// Root mean square over springs of several frequencies near one angle of a step.
struct LongRun {
  Precision precision = Precision::float64;
  double z = 0;  // rad: angular frequency times step
  std::uint64_t steps = 0;
  double energy = 0;      // |E/E0 - 1|
  double phase = 0;       // rad
  double walk = 0;        // |E/E0 - 1| of a random walk by the rounding of the state alone
  double walk_phase = 0;  // rad, the same for the phase
};

// `steps` is the longest run. Each curve gives a row for it, and one for each of three decades below. tell(curves done) is
// called after each angle and precision.
inline constexpr std::size_t long_run_curves = 9;
[[nodiscard]] std::vector<LongRun> measure_long_runs(std::uint64_t steps, const std::function<void(std::size_t)>& tell);

[[nodiscard]] std::string to_text(const std::vector<LongRun>& runs);
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<LongRun>& runs);

}  // namespace dvdx::tool::stability
