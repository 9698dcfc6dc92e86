// A hard case: a number, the reason why it is hard, and its bars. A bar holds one figure, the worst over the case's
// parameters, against a limit, in one precision; the same check runs on every instruction set.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dvdx/isa.hpp"

namespace dvdx::tool::stability {

// Precisions, as the command line calls them.
inline constexpr std::string_view float64 = "float64";
inline constexpr std::string_view float32 = "float32";
inline constexpr std::string_view float32_compensated = "float32_compensated";

// A long run is looked at so many times, as far apart.
inline constexpr int all_looks = 100;

// A tenth of the steps, for cloth that hangs for 1e5: half of the time of all cases.
enum class Duration { whole, tenth };

// On what a check runs, and the bits that its trials leave: they must be alike on every instruction set of one arithmetic.
struct CaseRun {
  Isa isa = Isa::reference;
  Arithmetic arithmetic = Arithmetic::separate;
  int looks = all_looks;  // at a long run that is only_best_whole
  Duration duration = Duration::whole;
  std::uint64_t bits = 0xCBF29CE484222325U;
};

// The largest value seen, and where.
struct Worst {
  double value = 0;   // once it is not a number it stays so
  std::string where;  // "omega h = 3"; empty where the check has one place alone

  void see(double seen, std::string_view at = {}) {
    if (std::isnan(value) || seen <= value) return;
    value = seen;
    where = at;
  }
};

using Check = Worst (*)(CaseRun& way);

// A bar that the kernel does not meet: the figure that was measured, rounded up, which it must not exceed, and why.
struct KnownMiss {
  double at_most = 0;
  std::string_view reason;
};

// Where a bar runs. A run that takes a minute of a fast instruction set takes an hour of the reference: only_best_whole runs
// whole on the best alone, and up to its first look on every one, for the bits.
enum class RunsOn { every_isa, best_isa, only_best_whole };

// Met where the check's figure is at most `limit`.
struct Bar {
  std::string_view precision = float64;
  Check check = nullptr;
  double limit = 0;
  std::string_view unit;      // "m", "A" (amplitudes), "" where the figure has none
  std::string_view expected;  // what should come out
  std::optional<KnownMiss> known_miss{};
  RunsOn runs_on = RunsOn::every_isa;
};

struct Case {
  int number = 0;
  std::string_view name;
  std::string_view hard;  // what is
  std::vector<Bar> bars;
};

// The same check in either precision, a limit each.
template <Check in_float64, Check in_float32>
[[nodiscard]] std::vector<Bar> both(double limit64, double limit32, std::string_view unit, std::string_view expected) {
  return {{.precision = float64, .check = in_float64, .limit = limit64, .unit = unit, .expected = expected},
          {.precision = float32, .check = in_float32, .limit = limit32, .unit = unit, .expected = expected}};
}

}  // namespace dvdx::tool::stability
