#include "hard_cases/suite.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <functional>
#include <future>
#include <limits>
#include <numeric>

namespace dvdx::tool::stability {
namespace {

struct Outcome {
  Isa isa = Isa::reference;
  Worst worst;
  std::uint64_t bits = 0;
  std::string refused;
};

Outcome outcome_of(const Bar& bar, Isa isa, Arithmetic arithmetic) {
  Way way{.isa = isa, .arithmetic = arithmetic};
  try {
    Worst worst = bar.check(way);
    return {.isa = isa, .worst = std::move(worst), .bits = way.bits, .refused = {}};
  } catch (const std::runtime_error& error) {
    return {.isa = isa,
            .worst = {.value = std::numeric_limits<double>::quiet_NaN(), .where = {}},
            .bits = way.bits,
            .refused = error.what()};
  }
}

bool is_worse(const Outcome& a, const Outcome& b) { return a.worst.value < b.worst.value || std::isnan(b.worst.value); }

std::string differing(const std::vector<Outcome>& outcomes) {
  std::string names;
  for (const Outcome& outcome : outcomes) {
    if (outcome.bits == outcomes.front().bits) continue;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", name(outcome.isa));
  }
  return names;
}

std::string note_of(const Outcome& worst, const std::string& differs, bool is_met, std::string_view reason) {
  std::string note = worst.refused.empty() ? worst.worst.where : "refused: " + worst.refused;
  const auto add = [&](std::string_view text) { note += fmt::format("{}{}", note.empty() ? "" : "; ", text); };
  if (!is_met && !reason.empty()) add(reason);
  if (!differs.empty()) add("other bits than the reference: " + differs);
  return note;
}

Row run_bar(const Case& hard_case, const Bar& bar, Arithmetic arithmetic) {
  std::vector<std::future<Outcome>> runs;
  for (const Isa isa : available_isas(arithmetic)) {
    runs.push_back(std::async(std::launch::async, outcome_of, std::cref(bar), isa, arithmetic));
  }
  std::vector<Outcome> outcomes;
  for (auto& run : runs) outcomes.push_back(run.get());
  const Outcome& worst = *std::max_element(outcomes.begin(), outcomes.end(), is_worse);
  const std::string differs = differing(outcomes);
  const bool is_met = worst.worst.value <= bar.limit;
  Row row{.number = hard_case.number,
          .name = std::string(hard_case.name),
          .hard = std::string(hard_case.hard),
          .precision = std::string(bar.precision),
          .expected = std::string(bar.expected),
          .bar = bar.limit,
          .got = worst.worst.value,
          .unit = std::string(bar.unit),
          .passed = is_met && differs.empty(),
          .isas = {},
          .note = note_of(worst, differs, is_met, bar.reason)};
  for (const Outcome& outcome : outcomes) row.isas.emplace_back(name(outcome.isa));
  return row;
}

}  // namespace

std::size_t bars_in(const std::vector<Case>& cases) {
  return std::accumulate(cases.begin(), cases.end(), std::size_t{0},
                         [](std::size_t sum, const Case& c) { return sum + c.bars.size(); });
}

std::vector<Row> run_cases(const std::vector<Case>& cases, Arithmetic arithmetic,
                           const std::function<void(std::size_t)>& tell) {
  std::vector<Row> rows;
  for (const Case& hard_case : cases) {
    for (const Bar& bar : hard_case.bars) {
      rows.push_back(run_bar(hard_case, bar, arithmetic));
      tell(rows.size());
    }
  }
  return rows;
}

bool all_passed(const std::vector<Row>& rows) {
  return std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.passed; });
}

}  // namespace dvdx::tool::stability
