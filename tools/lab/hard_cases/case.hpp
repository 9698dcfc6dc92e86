// A hard case has a number, the reason why it is hard, and its bars. A bar compares one figure, the worst over the case's
// parameters, with a limit in one precision. The same check runs on every instruction set.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dvdx/isa.hpp"

namespace dvdx::tool::stability {

// Precisions, by their names on the command line.
inline constexpr std::string_view float64 = "float64";
inline constexpr std::string_view float32 = "float32";
inline constexpr std::string_view float32_compensated = "float32_compensated";

// The number of samples of a long run, equally spaced in time.
inline constexpr int all_looks = 100;

// A tenth of the steps, for cloth that hangs for 1e5 steps: those runs take half of the time of all cases.
enum class Duration { whole, tenth };

// The conditions of a check, and a hash of its trials' states. The hash must agree on all instruction sets of one arithmetic.
struct CaseRun {
  Isa isa = Isa::reference;
  Arithmetic arithmetic = Arithmetic::separate;
  int looks = all_looks;  // samples of a long run; RunsOn::only_best_whole runs up to the first one on the others
  Duration duration = Duration::whole;
  std::uint64_t bits = 0xCBF29CE484222325U;
};

// The largest value seen, and its place.
struct Worst {
  double value = 0;   // once NaN, it stays NaN
  std::string where;  // "omega h = 3"; empty if the check has only one place

  void see(double seen, std::string_view at = {}) {
    if (std::isnan(value) || seen <= value) return;
    value = seen;
    where = at;
  }
};

using Check = Worst (*)(CaseRun& way);

// A bar that the kernel does not meet: the measured figure, rounded up, as a limit, and the reason.
struct KnownMiss {
  double at_most = 0;
  std::string_view reason;
};

// The instruction sets that run a bar. A run of a minute on a fast instruction set takes an hour on the reference.
// only_best_whole runs the whole length on the best instruction set only, and up to the first sample on every one, to compare
// the bits.
enum class RunsOn { every_isa, best_isa, only_best_whole };

// A bar is met if the check's figure is at most `limit`.
struct Bar {
  std::string_view precision = float64;
  Check check = nullptr;
  double limit = 0;
  std::string_view unit;      // "m", "A" (amplitudes), "" for a figure without a unit
  std::string_view expected;  // the expected result
  std::optional<KnownMiss> known_miss{};
  RunsOn runs_on = RunsOn::every_isa;
};

struct Case {
  int number = 0;
  std::string_view name;
  std::string_view hard;  // the reason why it is hard
  std::vector<Bar> bars;
};

// The same check in either precision, each with its limit.
template <Check in_float64, Check in_float32>
[[nodiscard]] std::vector<Bar> both(double limit64, double limit32, std::string_view unit, std::string_view expected) {
  return {{.precision = float64, .check = in_float64, .limit = limit64, .unit = unit, .expected = expected},
          {.precision = float32, .check = in_float32, .limit = limit32, .unit = unit, .expected = expected}};
}

}  // namespace dvdx::tool::stability
