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
  Arithmetic arithmetic = Arithmetic::separate;
  Worst worst;
  std::uint64_t bits = 0;
  std::string refused;
};

Outcome outcome_of(const Bar& bar, CaseRun way) {
  Outcome outcome{.isa = way.isa, .arithmetic = way.arithmetic, .worst = {}, .bits = 0, .refused = {}};
  try {
    outcome.worst = bar.check(way);
  } catch (const std::runtime_error& error) {
    outcome.worst.value = std::numeric_limits<double>::quiet_NaN();
    outcome.refused = error.what();
  }
  outcome.bits = way.bits;
  return outcome;
}

bool is_worse(const Outcome& a, const Outcome& b) { return a.worst.value < b.worst.value || std::isnan(b.worst.value); }

std::string name_of(const Outcome& outcome) {
  if (outcome.arithmetic == Arithmetic::separate) return std::string(name(outcome.isa));
  return fmt::format("{} {}", name(outcome.isa), name(outcome.arithmetic));
}

// Names the instruction sets whose bits differ from the first one with the same arithmetic, which is the reference if it ran.
// Fast arithmetic is exempt: each instruction set may have its own bits.
std::string differing(const std::vector<Outcome>& outcomes) {
  std::string names;
  for (const Outcome& outcome : outcomes) {
    if (outcome.arithmetic == Arithmetic::fast) continue;
    const auto first = std::find_if(outcomes.begin(), outcomes.end(),
                                    [&](const Outcome& other) { return other.arithmetic == outcome.arithmetic; });
    if (outcome.bits != first->bits) names += fmt::format("{}{}", names.empty() ? "" : ", ", name_of(outcome));
  }
  return names;
}

Verdict verdict_of(const Bar& bar, double got) {
  if (got <= bar.limit) return Verdict::met;
  return bar.known_miss && got <= bar.known_miss->at_most ? Verdict::known_miss : Verdict::missed;
}

std::string note_of(const Outcome& worst, const std::string& differs, Verdict verdict, const Bar& bar) {
  std::string note = worst.refused.empty() ? worst.worst.where : "refused: " + worst.refused;
  const auto add = [&](std::string_view text) { note += fmt::format("{}{}", note.empty() ? "" : "; ", text); };
  if (worst.worst.value > 0 && worst.arithmetic != Arithmetic::separate) add(name(worst.arithmetic));
  if (verdict != Verdict::met && bar.known_miss) {
    add(fmt::format("known to be missed, by at most {:.3g}: {}", bar.known_miss->at_most, bar.known_miss->reason));
  }
  if (!differs.empty()) add("other bits than the reference: " + differs);
  return note;
}

std::vector<Outcome> outcomes_of(const Bar& bar, RunsOn runs_on, const CaseRun& each) {
  std::vector<std::future<Outcome>> runs;
  for (const Arithmetic arithmetic : {Arithmetic::separate, Arithmetic::contracted, Arithmetic::fast}) {
    auto isas = available_isas(arithmetic);
    if (runs_on != RunsOn::every_isa) isas = {isas.back()};
    if (arithmetic == Arithmetic::fast) {
      if (runs_on == RunsOn::best_isa) continue;  // a minute each
      std::erase(isas, Isa::reference);           // the reference would run contracted arithmetic, and has done so
    }
    for (const Isa isa : isas) {
      CaseRun way = each;
      way.isa = isa;
      way.arithmetic = arithmetic;
      runs.push_back(std::async(std::launch::async, outcome_of, std::cref(bar), way));
    }
  }
  std::vector<Outcome> outcomes;
  for (auto& run : runs) outcomes.push_back(run.get());
  return outcomes;
}

Row run_bar(const Case& hard_case, const Bar& bar, Duration duration) {
  const std::vector<Outcome> outcomes = outcomes_of(bar, bar.runs_on, {.duration = duration});
  const bool is_begun = bar.runs_on == RunsOn::only_best_whole;
  const std::vector<Outcome> compared =
      is_begun ? outcomes_of(bar, RunsOn::every_isa, {.looks = 1, .duration = duration}) : outcomes;
  const Outcome& worst = *std::max_element(outcomes.begin(), outcomes.end(), is_worse);
  const std::string differs = differing(compared);
  const Verdict verdict = verdict_of(bar, worst.worst.value);
  Row row{.number = hard_case.number,
          .name = std::string(hard_case.name),
          .hard = std::string(hard_case.hard),
          .precision = std::string(bar.precision),
          .expected = std::string(bar.expected),
          .bar = bar.limit,
          .got = worst.worst.value,
          .unit = std::string(bar.unit),
          .verdict = differs.empty() ? verdict : Verdict::missed,
          .isas = {},
          .note = note_of(worst, differs, verdict, bar)};
  for (const Outcome& outcome : compared) row.isas.push_back(name_of(outcome));
  return row;
}

}  // namespace

std::size_t bars_in(const std::vector<Case>& cases) {
  return std::accumulate(cases.begin(), cases.end(), std::size_t{0},
                         [](std::size_t sum, const Case& c) { return sum + c.bars.size(); });
}

std::vector<Row> run_cases(const std::vector<Case>& cases, Duration duration, const std::function<void(std::size_t)>& tell) {
  std::vector<Row> rows;
  for (const Case& hard_case : cases) {
    for (const Bar& bar : hard_case.bars) {
      rows.push_back(run_bar(hard_case, bar, duration));
      tell(rows.size());
    }
  }
  return rows;
}

bool all_passed(const std::vector<Row>& rows) {
  return std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.passed(); });
}

}  // namespace dvdx::tool::stability
