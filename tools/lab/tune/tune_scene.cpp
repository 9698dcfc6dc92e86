#include "tune/tune_scene.hpp"

#include <algorithm>
#include <chrono>
#include <limits>

#include "tune/bench.hpp"
#include "tune/words.hpp"

namespace dvdx::tool::tune {
namespace {

using report::WallClock;

double seconds_since(WallClock::time_point start) { return std::chrono::duration<double>(WallClock::now() - start).count(); }

WallClock::time_point after(WallClock::time_point start, double seconds) {
  return start + std::chrono::duration_cast<WallClock::duration>(std::chrono::duration<double>(seconds));
}

class SceneTuner {
 public:
  SceneTuner(const SceneOptions& options, const SearchOptions& wish, const report::Setup& setup, const ProgressCallback& tell)
      : options_(options),
        wish_(wish),
        setup_(setup),
        tell_(tell),
        start_(WallClock::now()),
        file_(load_scene(options, Precision::float64).file),
        judge_(file_, wish.goal, until(reference_part)),
        reference_seconds_(seconds_since(start_)),
        watch_(file_, judge_.grid(), setup),
        bench_(judge_, watch_, after(start_, search_part * wish.seconds), after(start_, race_part * wish.seconds),
               [this](const auto& what) { say(what); }) {}

  Tuning tune() {
    Tuning tuning = described();
    if (tuning.is_judged()) {
      const auto ladders = ladders_of(file_, judge_.grid(), [this](const Coupling& coupling, std::uint64_t parts) {
        return judge_.fewest_substeps(coupling, parts);
      });
      tuning.findings = search(ladders, wish_.goal, Thoroughness::search, bench_);
      if (tuning.seeds > 0 && tuning.choice() != nullptr) hold_out(ladders, tuning);
      if (const auto* choice = tuning.choice()) {
        put_in_words(*choice, tuning);
        offer_fast(*choice, tuning);
        give_advice(*choice, tuning);
        if (wish_.thoroughness == Thoroughness::exhaustive) compare_with_all(ladders, *choice, tuning);
      }
    }
    tuning.seconds = seconds_since(start_);
    return tuning;
  }

 private:
  // Fractions of the time at which each phase ends. The rest is for the advice.
  static constexpr double reference_part = 0.3;
  static constexpr double search_part = 0.7;
  static constexpr double race_part = 0.85;

  [[nodiscard]] report::Setup until(double part) const {
    report::Setup setup = setup_;
    setup.end = after(start_, part * wish_.seconds);
    return setup;
  }

  void say(const std::string& what) { tell_(std::min(0.99, seconds_since(start_) / wish_.seconds), what); }

  [[nodiscard]] Tuning described() const {
    const auto& grid = judge_.grid();
    return {.scene = file_.name,
            .particles = file_.particles.count,
            .error_particles = judge_.reference().path.particles,
            .duration = file_.duration,
            .compared = judge_.reference().facts.horizon.seconds,
            .amplitude = judge_.reference().amplitude,
            .goal = wish_.goal,
            .coarsest = grid.coarsest,
            .finest = grid.step(grid.halvings),
            .seeds = seeds_in(options_),
            .reference = judge_.reference().facts,
            .findings = {},
            .run_options = {},
            .scene_lines = {},
            .reference_seconds = reference_seconds_,
            .budget = wish_.seconds};
  }

  // The cheapest candidate that keeps the goal with other random values too: an error just below the goal may be luck. If all
  // that were raced fail, the search aims lower.
  void hold_out(const std::vector<Ladder>& ladders, Tuning& tuning) {
    auto other = options_;
    other.seed = options_.seed.value_or(0) + 1;
    const auto file = load_scene(other, Precision::float64).file;
    const Judge judge(file, wish_.goal, until(race_part));
    const auto holds = [&](const Candidate& candidate) {
      say("error of " + text_of(candidate) + " with other seeds");
      const auto outcome = judge.errors(candidate, {}, after(start_, wish_.seconds));
      if (outcome.is_cut) return true;  // not known to fail
      tuning.other_seed = OtherSeed{.seed = *other.seed, .outcome = outcome};
      return outcome.keeps(wish_.goal);
    };
    choose(tuning.findings, wish_.goal, holds);
    constexpr double lower = 0.7;
    constexpr double lowest = 0.1;
    for (double part = lower; tuning.choice() == nullptr && part > lowest && !bench_.is_over(); part *= lower) {
      tuning.findings = search(ladders, part * wish_.goal, Thoroughness::search, bench_);
      choose(tuning.findings, wish_.goal, holds);
    }
  }

  void put_in_words(const Trial& choice, Tuning& tuning) const {
    tuning.run_options = run_options(options_, file_, choice.candidate);
    tuning.scene_lines = scene_lines(options_, file_, choice.candidate);
  }

  // Only the roots of springs are estimated in fast arithmetic.
  void offer_fast(const Trial& choice, Tuning& tuning) {
    const auto isas = available_isas(Arithmetic::fast);
    const bool has_it = std::find(isas.begin(), isas.end(), setup_.engine.isa) != isas.end();
    if (!has_it || setup_.engine.arithmetic == Arithmetic::fast || file_.scene.networks.empty()) return;
    Candidate candidate = choice.candidate;
    candidate.arithmetic = Arithmetic::fast;
    Fast fast{.outcome = bench_.errors(candidate)};
    if (fast.outcome.ran()) {
      const auto costs = bench_.race({choice.candidate, candidate});
      if (costs[0].ns_per_particle_step > 0) fast.cost_ratio = costs[1].ns_per_particle_step / costs[0].ns_per_particle_step;
    }
    if (!fast.outcome.is_cut) tuning.fast = fast;
  }

  void give_advice(const Trial& choice, Tuning& tuning) {
    const auto& candidate = choice.candidate;
    const auto last = after(start_, wish_.seconds);
    const auto errors = [&](const Judge::Change& change) {
      say("advice");
      return judge_.errors(candidate, change, last);
    };
    const auto cost_ratio = [&](const Judge::Change& change) {
      constexpr int rounds = 3;
      double own = std::numeric_limits<double>::infinity();
      double changed = own;
      for (int round = 0; round < rounds && (round == 0 || WallClock::now() < last); ++round) {
        own = std::min(own, watch_.time(candidate).ns_per_particle_step);
        changed = std::min(changed, watch_.time(candidate, change).ns_per_particle_step);
      }
      return changed / own;
    };
    tuning.advice = advise(file_.scene, candidate, wish_.goal, errors, cost_ratio);
  }

  // Races the cheapest of all ladders, first among themselves and then beside the choice.
  void compare_with_all(const std::vector<Ladder>& ladders, const Trial& choice, Tuning& tuning) {
    const auto all = search(ladders, wish_.goal, Thoroughness::exhaustive, bench_);
    std::vector<Trial> racers{choice};
    for (const auto& trial : all.trials) {
      if (trial.is_timed && trial.candidate != choice.candidate) racers.push_back(trial);
    }
    std::vector<Candidate> candidates;
    for (const auto& racer : racers) candidates.push_back(racer.candidate);
    const auto costs = bench_.race(candidates);
    for (std::size_t k = 0; k < racers.size(); ++k) racers[k].cost = costs[k];
    const auto best = std::min_element(racers.begin(), racers.end(), [](const Trial& a, const Trial& b) {
      return a.cost.seconds_per_simulated_second < b.cost.seconds_per_simulated_second;
    });
    tuning.exhaustive = Exhaustive{.candidates = all.trials.size(), .best = *best, .choice = costs.front()};
  }

  const SceneOptions& options_;
  const SearchOptions& wish_;
  const report::Setup& setup_;
  const ProgressCallback& tell_;
  WallClock::time_point start_;
  SceneFile file_;
  Judge judge_;
  double reference_seconds_;
  Watch watch_;
  Bench bench_;
};

}  // namespace

Tuning tune_scene(const SceneOptions& options, const SearchOptions& wish, const report::Setup& setup,
                  const ProgressCallback& tell) {
  return SceneTuner(options, wish, setup, tell).tune();
}

}  // namespace dvdx::tool::tune
