// Runs hard cases: each bar on every instruction set of this machine in every arithmetic. In separate and in contracted
// arithmetic all must agree bit by bit.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "hard_cases/case.hpp"

namespace dvdx::tool::stability {

// A known miss passes: its figure is no worse than the one that is documented.
enum class Verdict { met, known_miss, missed };

// One bar and what came of it.
struct Row {
  int number = 0;
  std::string name;
  std::string hard;
  std::string precision;
  std::string expected;
  double bar = 0;
  double got = 0;  // not a number where a state was not, or where the library refused
  std::string unit;
  Verdict verdict = Verdict::missed;
  std::vector<std::string> isas;  // that ran it, "avx2 contracted"
  std::string note;               // where the worst was seen, which instruction set differs, why the bar is missed

  [[nodiscard]] bool passed() const noexcept { return verdict != Verdict::missed; }
};

[[nodiscard]] std::size_t bars_in(const std::vector<Case>& cases);

// tell(bars done) is called after each bar.
[[nodiscard]] std::vector<Row> run_cases(const std::vector<Case>& cases, Duration duration,
                                         const std::function<void(std::size_t)>& tell);

[[nodiscard]] bool all_passed(const std::vector<Row>& rows);

}  // namespace dvdx::tool::stability
