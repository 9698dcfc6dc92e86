#include "tune/search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dvdx::tool::tune {
namespace {

constexpr double doubt = 1.6;   // error factor of a rough cost: a candidate beyond best_ times this cannot win
constexpr double a_tie = 1.03;  // a ratio of costs up to this counts as equal
constexpr std::size_t most_racers = 8;

class Search {
 public:
  Search(const std::vector<Ladder>& ladders, double goal, Probe& probe) : ladders_(ladders), goal_(goal), probe_(probe) {}

  Findings bracket_all() {
    for (const auto& ladder : ladders_) {
      if (probe_.is_over()) {
        findings_.not_run.push_back({.ladder = ladder.name, .why = NotRun::Why::time});
        continue;
      }
      climb(ladder);
    }
    race();
    return std::move(findings_);
  }

  Findings measure_all() {
    for (const auto& ladder : ladders_) {
      for (std::size_t rung = 0; rung < ladder.rungs.size(); ++rung) {
        const auto trial = measure(ladder, rung);
        if (!keeps(trial)) continue;
        findings_.trials[trial].cost = probe_.rough_cost(ladder.rungs[rung]);
        best_ = std::min(best_, seconds(trial));
      }
    }
    race();
    return std::move(findings_);
  }

 private:
  // ---- measuring ---------------------------------------------------------------------------------------------------------

  std::size_t measure(const Ladder& ladder, std::size_t rung) {
    const auto& candidate = ladder.rungs[rung];
    findings_.trials.push_back(
        {.ladder = ladder.name, .candidate = candidate, .outcome = probe_.errors(candidate), .cost = {}});
    return findings_.trials.size() - 1;
  }

  [[nodiscard]] double error(std::size_t trial) const {
    const auto& outcome = findings_.trials[trial].outcome;
    return outcome.ran() ? outcome.errors.relative : std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] bool is_cut(std::size_t trial) const { return findings_.trials[trial].outcome.is_cut; }
  [[nodiscard]] bool keeps(std::size_t trial) const { return findings_.trials[trial].outcome.keeps(goal_); }
  [[nodiscard]] double seconds(std::size_t trial) const { return findings_.trials[trial].cost.seconds_per_simulated_second; }

  // ---- one ladder --------------------------------------------------------------------------------------------------------

  // Climbs from the coarsest rung to the first that keeps the goal or that costs more than the best so far.
  void climb(const Ladder& ladder) {
    const auto first = findings_.trials.size();
    std::optional<Cost> unit;
    if (std::isfinite(best_)) {
      unit = unit_cost(ladder.rungs[0]);
      if (unit && unit->seconds_per_simulated_second * ladder.rungs[0].work() > doubt * best_) {
        findings_.not_run.push_back({.ladder = ladder.name, .why = NotRun::Why::dearer});
        return;
      }
    }
    const auto measured = [&](std::size_t rung) {
      const auto trial = measure(ladder, rung);
      if (!unit && findings_.trials[trial].outcome.ran()) unit = unit_cost(ladder.rungs[rung]);
      if (unit) price(first, *unit);
      return trial;
    };
    auto low = measured(0);
    if (keeps(low)) return take(low);
    if (!findings_.trials[low].outcome.refused.empty()) return;
    if (is_cut(low)) return give_up(ladder);
    std::size_t low_rung = 0;
    auto high_rung = finest_worth(ladder, unit);
    std::optional<std::size_t> high;  // a trial that keeps the goal
    double slope = ladder.order;
    while (low_rung + (high ? 1U : 0U) < high_rung && !probe_.is_over()) {
      const auto rung = next_rung(ladder, low_rung, high_rung, high.has_value(), error(low), slope);
      const auto trial = measured(rung);
      if (is_cut(trial)) break;
      if (keeps(trial)) {
        high = trial;
        high_rung = rung;
        continue;
      }
      if (!high) high_rung = finest_worth(ladder, unit);
      slope = std::max(slope_between(low, trial, slope), hopeless);
      low = trial;
      low_rung = rung;
    }
    if (high) take(*high);
    if (low_rung + (high ? 1U : 0U) < high_rung) give_up(ladder);
  }
  void give_up(const Ladder& ladder) { findings_.not_run.push_back({.ladder = ladder.name, .why = NotRun::Why::time}); }

  static constexpr double hopeless = 0.1;  // least slope: rounding or the method's limit dominates; the finest rung decides

  // Guesses the rung where the error meets the goal, strictly between a miss and a rung that keeps it (or the finest).
  static std::size_t next_rung_of(const Ladder& ladder, std::size_t low, std::size_t high, bool high_keeps, double work) {
    const auto last = high_keeps ? high - 1 : high;
    auto rung = low + 1;
    while (rung < last && ladder.rungs[rung].work() < work) ++rung;
    return rung;
  }
  [[nodiscard]] std::size_t next_rung(const Ladder& ladder, std::size_t low, std::size_t high, bool high_keeps, double error,
                                      double slope) const {
    const double work = ladder.rungs[low].work();
    if (high_keeps && high - low > 4) return low + (high - low) / 2;  // the guess has failed: bisect
    if (!std::isfinite(error)) return next_rung_of(ladder, low, high, high_keeps, 2 * work);
    return next_rung_of(ladder, low, high, high_keeps, 0.999 * work * std::pow(error / goal_, 1 / slope));
  }

  [[nodiscard]] double slope_between(std::size_t coarse, std::size_t fine, double otherwise) const {
    if (!std::isfinite(error(coarse)) || !std::isfinite(error(fine))) return otherwise;
    const double work = findings_.trials[fine].candidate.work() / findings_.trials[coarse].candidate.work();
    return std::clamp(std::log(error(coarse) / error(fine)) / std::log(work), 0.0, 8.0);
  }

  // The cost of a unit of work; none if the candidate is refused, or the time is over.
  std::optional<Cost> unit_cost(const Candidate& candidate) {
    auto cost = probe_.rough_cost(candidate);
    if (cost.seconds_per_simulated_second == 0) return std::nullopt;
    cost.ns_per_particle_step /= candidate.substeps();
    cost.seconds_per_simulated_second /= candidate.work();
    return cost;
  }

  void price(std::size_t first, const Cost& unit) {
    for (auto n = first; n < findings_.trials.size(); ++n) {
      auto& trial = findings_.trials[n];
      trial.cost = {.ns_per_particle_step = unit.ns_per_particle_step * trial.candidate.substeps(),
                    .seconds_per_simulated_second = unit.seconds_per_simulated_second * trial.candidate.work()};
    }
  }

  [[nodiscard]] std::size_t finest_worth(const Ladder& ladder, const std::optional<Cost>& unit) const {
    auto rung = ladder.rungs.size() - 1;
    if (!unit) return rung;
    while (rung > 0 && unit->seconds_per_simulated_second * ladder.rungs[rung].work() > doubt * best_) --rung;
    return rung;
  }

  void take(std::size_t trial) {
    if (seconds(trial) > 0) best_ = std::min(best_, seconds(trial));
  }

  // ---- all ladders -------------------------------------------------------------------------------------------------------

  // Races candidates that may be the cheapest, and then those that an estimate too low had hidden.
  void race() {
    auto racers = not_yet_raced();
    while (!racers.empty()) {
      std::vector<Candidate> candidates;
      for (const auto n : racers) candidates.push_back(findings_.trials[n].candidate);
      const auto costs = probe_.race(candidates);
      best_ = std::numeric_limits<double>::infinity();
      bool is_any_timed = false;
      for (std::size_t k = 0; k < racers.size(); ++k) {
        if (costs[k].seconds_per_simulated_second == 0) continue;
        findings_.trials[racers[k]].cost = costs[k];
        findings_.trials[racers[k]].is_timed = is_any_timed = true;
      }
      if (!is_any_timed) return;
      for (const auto& trial : findings_.trials) {
        if (trial.is_timed) best_ = std::min(best_, trial.cost.seconds_per_simulated_second);
      }
      racers = not_yet_raced();
    }
  }

  [[nodiscard]] std::vector<std::size_t> not_yet_raced() const {
    std::vector<std::size_t> racers;
    for (std::size_t n = 0; n < findings_.trials.size(); ++n) {
      const double most = raced_ever() ? best_ : doubt * best_;
      if (keeps(n) && !findings_.trials[n].is_timed && seconds(n) <= most) racers.push_back(n);
    }
    std::sort(racers.begin(), racers.end(), [&](std::size_t a, std::size_t b) { return seconds(a) < seconds(b); });
    if (racers.size() > most_racers) racers.resize(most_racers);
    return racers;
  }

  [[nodiscard]] bool raced_ever() const {
    return std::any_of(findings_.trials.begin(), findings_.trials.end(), [](const Trial& trial) { return trial.is_timed; });
  }

  const std::vector<Ladder>& ladders_;
  double goal_;
  Probe& probe_;
  Findings findings_;
  double best_ = std::numeric_limits<double>::infinity();  // s per simulated second, for candidates that keep the goal
};

double seconds_of(const Trial& trial) { return trial.cost.seconds_per_simulated_second; }
double error_of(const Trial& trial) { return trial.outcome.errors.relative; }

// Sorted by cost; among equal costs the most accurate comes first. Estimates count if no time was left for the race.
std::vector<std::size_t> by_cost(const std::vector<Trial>& trials, double goal) {
  const bool was_raced = std::any_of(trials.begin(), trials.end(), [](const Trial& trial) { return trial.is_timed; });
  std::vector<std::size_t> order;
  for (std::size_t n = 0; n < trials.size(); ++n) {
    const bool has_cost = was_raced ? trials[n].is_timed : seconds_of(trials[n]) > 0;
    if (has_cost && trials[n].outcome.keeps(goal)) order.push_back(n);
  }
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return seconds_of(trials[a]) < seconds_of(trials[b]); });
  for (auto first = order.begin(); first != order.end();) {
    const double most = a_tie * seconds_of(trials[*first]);
    const auto last = std::find_if(first, order.end(), [&](std::size_t n) { return seconds_of(trials[n]) > most; });
    std::sort(first, last, [&](std::size_t a, std::size_t b) { return error_of(trials[a]) < error_of(trials[b]); });
    first = last;
  }
  return order;
}

// The most expensive of the cheaper trials; among equal costs, the one with the smallest error.
std::optional<std::size_t> next_cheaper(const std::vector<Trial>& trials, std::size_t choice) {
  const double most = seconds_of(trials[choice]) / a_tie;
  const auto costs_less = [&](const Trial& t) { return t.outcome.ran() && seconds_of(t) > 0 && seconds_of(t) < most; };
  double dearest = 0;
  for (const auto& trial : trials) {
    if (costs_less(trial)) dearest = std::max(dearest, seconds_of(trial));
  }
  std::optional<std::size_t> found;
  for (std::size_t n = 0; n < trials.size(); ++n) {
    if (!costs_less(trials[n]) || seconds_of(trials[n]) < dearest / a_tie) continue;
    if (!found || error_of(trials[n]) < error_of(trials[*found])) found = n;
  }
  return found;
}

std::optional<std::size_t> next_finer(const std::vector<Trial>& trials, std::size_t choice) {
  std::optional<std::size_t> found;
  for (std::size_t n = 0; n < trials.size(); ++n) {
    if (n == choice || !trials[n].outcome.ran() || seconds_of(trials[n]) <= 0) continue;
    if (error_of(trials[n]) >= error_of(trials[choice])) continue;
    if (!found || seconds_of(trials[n]) < seconds_of(trials[*found])) found = n;
  }
  return found;
}

}  // namespace

Findings search(const std::vector<Ladder>& ladders, double goal, Thoroughness thoroughness, Probe& probe) {
  Search search(ladders, goal, probe);
  auto findings = thoroughness == Thoroughness::exhaustive ? search.measure_all() : search.bracket_all();
  choose(findings, goal, [](const Candidate&) { return true; });
  return findings;
}

void choose(Findings& findings, double goal, const std::function<bool(const Candidate&)>& accepts) {
  const auto& trials = findings.trials;
  findings.choice.reset();
  findings.cheaper.reset();
  findings.finer.reset();
  for (const auto n : by_cost(trials, goal)) {
    if (!accepts(trials[n].candidate)) continue;
    findings.choice = n;
    findings.cheaper = next_cheaper(trials, n);
    findings.finer = next_finer(trials, n);
    return;
  }
}

const Trial* most_accurate(const Findings& findings) {
  const Trial* best = nullptr;
  for (const auto& trial : findings.trials) {
    if (trial.outcome.ran() && (best == nullptr || error_of(trial) < error_of(*best))) best = &trial;
  }
  return best;
}

}  // namespace dvdx::tool::tune
