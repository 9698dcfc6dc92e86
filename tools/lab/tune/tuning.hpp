// The findings of a scene's tuning. Plain values.
#pragma once

#include <optional>
#include <string>

#include "report/results.hpp"
#include "tune/advice.hpp"

namespace dvdx::tool::tune {

// The choice with other random values.
struct OtherSeed {
  std::uint64_t seed = 0;
  Outcome outcome;
};

// The choice in fast arithmetic, whose bits may differ from machine to machine: offered, never chosen.
struct Fast {
  Outcome outcome;
  double cost_ratio = 0;  // relative to the choice; 0 if not timed
};

// The exhaustive search over all candidates, compared with the choice.
struct Exhaustive {
  std::size_t candidates = 0;
  Trial best;
  Cost choice;  // the choice's, in the race with the best
  [[nodiscard]] double ratio() const { return choice.seconds_per_simulated_second / best.cost.seconds_per_simulated_second; }
};

struct Tuning {
  std::string scene;
  std::size_t particles = 0;
  std::size_t error_particles = 0;
  double duration = 0;   // s
  double compared = 0;   // s, from the start: as far as the reference is known
  double amplitude = 0;  // m
  double goal = 0;       // relative
  double coarsest = 0;   // s, range of the steps tried
  double finest = 0;     // s
  std::size_t seeds = 0;
  report::ReferenceFacts reference;
  Findings findings;
  std::vector<std::string> run_options;  // for the choice
  std::vector<std::string> scene_lines;
  std::optional<OtherSeed> other_seed{};
  std::optional<Fast> fast{};  // none if it has the choice's bits
  Advice advice{};
  std::optional<Exhaustive> exhaustive{};
  double reference_seconds = 0;  // time of the reference
  double seconds = 0;            // time of everything
  double budget = 0;             // s

  [[nodiscard]] const Trial* choice() const { return trial(findings.choice); }
  [[nodiscard]] const Trial* trial(const std::optional<std::size_t>& index) const {
    return index ? &findings.trials[*index] : nullptr;
  }
  // Returns true if the reference can separate a run that keeps the goal from one that does not.
  [[nodiscard]] bool is_judged() const { return amplitude > 0 && reference.self_error <= 0.1 * goal * amplitude; }
};

}  // namespace dvdx::tool::tune
