// Finds the cheapest candidate that keeps an error goal, with as few measurements as possible.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "report/results.hpp"
#include "tune/candidates.hpp"

namespace dvdx::tool::tune {

// The outcome of a run: its errors, or the reason why there was no run.
struct Outcome {
  report::Errors errors;
  std::string refused{};  // the reason why the plan could not be made; empty if it ran
  bool is_cut = false;    // given up when the time was over

  [[nodiscard]] bool ran() const noexcept { return refused.empty() && !is_cut && !errors.diverged; }
  [[nodiscard]] bool keeps(double goal) const noexcept { return ran() && errors.relative <= goal; }
};

struct Cost {
  double ns_per_particle_step = 0;
  double seconds_per_simulated_second = 0;  // for all particles
};

// The measurements of a search. Tests replace them by formulas.
class Probe {
 public:
  Probe() = default;
  Probe(const Probe&) = delete;
  Probe& operator=(const Probe&) = delete;
  virtual ~Probe() = default;

  virtual Outcome errors(const Candidate& candidate) = 0;
  // Accurate to a few tens of per cent. The candidate must run.
  virtual Cost rough_cost(const Candidate& candidate) = 0;
  // Timed in alternation, the least of several each; zero for those that the time does not allow.
  virtual std::vector<Cost> race(const std::vector<Candidate>& candidates) = 0;
  virtual bool is_over() = 0;  // true after the search's time
};

struct Trial {
  std::string ladder;
  Candidate candidate;
  Outcome outcome;
  Cost cost;              // estimated from another rung of the ladder if not timed; zero if no rung was
  bool is_timed = false;  // in the race
};

// A ladder that was not run, or not completely, although its rest may have been cheaper.
struct NotRun {
  enum class Why { time, dearer };  // dearer: its coarsest rung costs more than a choice already found
  std::string ladder;
  Why why = Why::time;
};

struct Findings {
  std::vector<Trial> trials;           // everything measured
  std::optional<std::size_t> choice;   // the cheapest that keeps the goal; within a few per cent the most accurate
  std::optional<std::size_t> cheaper;  // the next cheaper, which misses
  std::optional<std::size_t> finer;    // the cheapest of those more accurate than the choice
  std::vector<NotRun> not_run;

  [[nodiscard]] bool is_cut() const noexcept {
    return std::any_of(not_run.begin(), not_run.end(), [](const NotRun& of) { return of.why == NotRun::Why::time; });
  }
};

enum class Thoroughness {
  search,      // brackets the goal in each ladder, and leaves a ladder once it can only cost more
  exhaustive,  // every rung of every ladder
};

[[nodiscard]] Findings search(const std::vector<Ladder>& ladders, double goal, Thoroughness thoroughness, Probe& probe);

// Chooses the cheapest again among those that `accepts` returns true for. It is asked in ascending order of cost.
void choose(Findings& findings, double goal, const std::function<bool(const Candidate&)>& accepts);

// The trial that ran with the least error.
[[nodiscard]] const Trial* most_accurate(const Findings& findings);

}  // namespace dvdx::tool::tune
