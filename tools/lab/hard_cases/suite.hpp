// Runs hard cases: each bar on every instruction set of this machine in every arithmetic. In separate and in contracted
// arithmetic all bits must agree.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "hard_cases/case.hpp"

namespace dvdx::tool::stability {

// A known miss passes: its figure is at most the documented one.
enum class Verdict { met, known_miss, missed };

// One bar and its result.
struct Row {
  int number = 0;
  std::string name;
  std::string hard;
  std::string precision;
  std::string expected;
  double bar = 0;
  double got = 0;  // NaN if a state was not finite, or if the library refused
  std::string unit;
  Verdict verdict = Verdict::missed;
  std::vector<std::string> isas;  // the instruction sets that ran it, "avx2 contracted"
  std::string note;               // the place of the worst figure, an instruction set that differs, the reason of a miss

  [[nodiscard]] bool passed() const noexcept { return verdict != Verdict::missed; }
};

[[nodiscard]] std::size_t bars_in(const std::vector<Case>& cases);

// tell(bars done) is called after each bar.
[[nodiscard]] std::vector<Row> run_cases(const std::vector<Case>& cases, Duration duration,
                                         const std::function<void(std::size_t)>& tell);

[[nodiscard]] bool all_passed(const std::vector<Row>& rows);

}  // namespace dvdx::tool::stability
