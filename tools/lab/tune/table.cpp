#include "tune/table.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "output/console.hpp"
#include "report/text_table.hpp"

namespace dvdx::tool::tune {
namespace {

std::string row(std::string_view name, const std::string& text) { return fmt::format("{:<10} {}\n", name, text); }

std::string error_text(const Outcome& outcome) {
  if (!outcome.refused.empty()) return "refused";
  if (outcome.is_cut) return "not run: no time was left";
  return outcome.errors.diverged ? "diverges" : fmt::format("{:.2g}", outcome.errors.relative);
}

std::string_view source_text(report::ReferenceSource source) {
  switch (source) {
    case report::ReferenceSource::formula:
      return "closed form";
    case report::ReferenceSource::impacts:
      return "closed form from impact to impact";
    case report::ReferenceSource::finer_steps:
      return "the same kernel at finer steps";
  }
  return "";
}

std::string head_text(const Tuning& tuning) {
  auto text = fmt::format("{}: {} particle{}, {} s; error goal {:g} of the amplitude, {:.4g} m\n", printable(tuning.scene),
                          tuning.particles, tuning.particles == 1 ? "" : "s", tuning.duration, tuning.goal, tuning.amplitude);
  const auto& reference = tuning.reference;
  text += row("reference",
              fmt::format("{}, own error {:.2g}", source_text(reference.source), reference.self_error / tuning.amplitude));
  text += row("looked at", fmt::format("{} runs, steps from {:.4g} s to {:.4g} s, errors on {} particle{}, in {:.0f} s",
                                       tuning.findings.trials.size(), tuning.coarsest, tuning.finest, tuning.error_particles,
                                       tuning.error_particles == 1 ? "" : "s", tuning.seconds));
  if (tuning.compared < tuning.duration * (1 - 1e-9)) {
    text += row("compared", fmt::format("the first {:.4g} s, as far as the reference is known", tuning.compared));
  }
  const auto cut = std::count_if(tuning.findings.not_run.begin(), tuning.findings.not_run.end(),
                                 [](const NotRun& of) { return of.why == NotRun::Why::time; });
  if (cut != 0) {
    text += row("CUT", fmt::format("{:g} s did not suffice: {} curve{} not run, or not to the end; a larger --budget does more",
                                   tuning.budget, cut, cut == 1 ? "" : "s"));
  }
  return text;
}

std::string joined(const std::vector<std::string>& words, std::string_view between) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : std::string(between)) + word;
  return text;
}

// A shell would interpret brackets in a path.
std::string quoted(const std::string& word) {
  return word.find_first_of("[]{}\" ") == std::string::npos ? word : "'" + word + "'";
}

std::string command_text(const std::vector<std::string>& options) {
  std::string text = "dvdx run";
  for (const auto& word : options) text += " " + quoted(word);
  return text;
}

std::string beside_text(const Trial& trial, const Trial& choice, double goal) {
  const double ratio = trial.cost.seconds_per_simulated_second / choice.cost.seconds_per_simulated_second;
  const double over = trial.outcome.errors.relative / goal;
  return fmt::format("{}: error {:.2g}, {:.2g} times the goal, at {:.2f} of the choice's time{}", text_of(trial.candidate),
                     trial.outcome.errors.relative, over, ratio, trial.is_timed ? "" : " (estimated)");
}

std::string other_seed_text(const Tuning& tuning) {
  if (tuning.seeds == 0) return "nothing in this scene is drawn from a seed";
  if (!tuning.other_seed) return "not measured";
  const auto& outcome = tuning.other_seed->outcome;
  return fmt::format("error {} with values drawn by --seed {}: {}", error_text(outcome), tuning.other_seed->seed,
                     outcome.keeps(tuning.goal) ? "keeps the goal" : "MISSES the goal");
}

std::string fast_text(const Tuning& tuning) {
  if (!tuning.fast) return "";
  const auto& [outcome, cost_ratio] = *tuning.fast;
  if (!outcome.ran()) return row("fast", fmt::format("--arithmetic fast: {}", error_text(outcome)));
  return row("fast",
             fmt::format("--arithmetic fast: error {:.3g}, at {:.2f} of the choice's time; its bits are this machine's own",
                         outcome.errors.relative, cost_ratio));
}

std::string choice_text(const Tuning& tuning, const Trial& choice) {
  std::string text = row("choice", text_of(choice.candidate));
  text += row("error", fmt::format("{:.3g} (position {:.3g} m rms, {:.3g} m at most)", choice.outcome.errors.relative,
                                   choice.outcome.errors.position_rms, choice.outcome.errors.position_max));
  text += row("again", other_seed_text(tuning));
  text += row("cost", fmt::format("{:.3g} ns per particle-step, {:.3g} s per simulated second",
                                  choice.cost.ns_per_particle_step, choice.cost.seconds_per_simulated_second));
  const auto* cheaper = tuning.trial(tuning.findings.cheaper);
  text += row("cheaper", cheaper == nullptr ? "none of those looked at" : beside_text(*cheaper, choice, tuning.goal));
  const auto* finer = tuning.trial(tuning.findings.finer);
  text += row("finer", finer == nullptr ? "none of those looked at" : beside_text(*finer, choice, tuning.goal));
  text += fast_text(tuning);
  text += row("run", command_text(tuning.run_options));
  text += row("scene file", joined(tuning.scene_lines, ", "));
  return text;
}

// The runs of a curve, the coarsest first.
struct CurveRuns {
  std::string curve;
  std::size_t runs = 0;
  const Trial* best = nullptr;  // the most accurate
  std::string refused{};
  std::string note{};
};

std::vector<CurveRuns> curves_of(const Tuning& tuning) {
  std::vector<CurveRuns> curves;
  const auto of = [&](const std::string& name) -> CurveRuns& {
    const auto found = std::find_if(curves.begin(), curves.end(), [&](const CurveRuns& c) { return c.curve == name; });
    return found != curves.end() ? *found : curves.emplace_back(CurveRuns{.curve = name});
  };
  for (const auto& trial : tuning.findings.trials) {
    auto& curve = of(trial.ladder);
    const auto& outcome = trial.outcome;
    if (!outcome.refused.empty()) curve.refused = outcome.refused;
    if (!outcome.refused.empty() || outcome.is_cut) continue;
    ++curve.runs;
    const bool is_better =
        outcome.ran() && (curve.best == nullptr || outcome.errors.relative < curve.best->outcome.errors.relative);
    if (is_better) curve.best = &trial;
  }
  for (const auto& [name, why] : tuning.findings.not_run) {
    const bool was_run = of(name).runs > 0;
    of(name).note = why == NotRun::Why::dearer ? "not run: its coarsest run costs more than what keeps the goal"
                    : was_run                  ? "then no time was left"
                                               : "not run: no time was left";
  }
  return curves;
}

// Whether each curve was run. Curves with the same text share a line.
std::string curves_text(const Tuning& tuning) {
  std::string text;
  std::vector<std::pair<std::string, std::string>> said;
  for (const auto& curve : curves_of(tuning)) {
    std::string what;
    if (curve.best != nullptr) {
      what = fmt::format("{} run{}, the most accurate {:.2g}", curve.runs, curve.runs == 1 ? "" : "s",
                         curve.best->outcome.errors.relative);
    } else if (curve.runs > 0) {
      what = fmt::format("{} run{}, none stayed finite", curve.runs, curve.runs == 1 ? "" : "s");
    } else if (!curve.refused.empty()) {
      what = "refused: " + curve.refused;
    }
    if (!curve.note.empty()) what += (what.empty() ? "" : "; ") + curve.note;
    const auto same = std::find_if(said.begin(), said.end(), [&](const auto& line) { return line.second == what; });
    if (same == said.end()) {
      said.emplace_back(curve.curve, what);
    } else {
      same->first += " | " + curve.curve;
    }
  }
  for (const auto& [curves, what] : said) text += fmt::format("  {}: {}\n", curves, what);
  return text.empty() ? "" : "curves, each from the coarsest run on\n" + text;
}

std::string exhaustive_text(const Tuning& tuning) {
  if (!tuning.exhaustive) return "";
  const auto& all = *tuning.exhaustive;
  return row("all",
             fmt::format("{} candidates; the cheapest is {}: {:.3g} s per simulated second; choice / cheapest {:.3f}",
                         all.candidates, text_of(all.best.candidate), all.best.cost.seconds_per_simulated_second, all.ratio()));
}

std::string advice_word(const Part& part) {
  const auto has = [&](const std::string& name) {
    return std::any_of(part.changes.begin(), part.changes.end(), [&](const Change& c) { return c.name == name; });
  };
  if (part.advice == "leave_out") return "may be left out";
  if (part.advice == "keep") return "is needed";
  return (has(part.advice) ? "may be " : "must be ") + part.advice;
}

std::string parts_text(std::string_view noun, const std::vector<Part>& parts) {
  if (parts.empty()) return "";
  report::TextTable table(3);
  for (const auto& part : parts) {
    std::string errors;
    for (const auto& change : part.changes) {
      errors += fmt::format("{}{} {}", errors.empty() ? "" : ", ", change.name, error_text(change.outcome));
      if (change.cost_ratio > 0) errors += fmt::format(" ({:.2f} of the time)", change.cost_ratio);
    }
    table.row({fmt::format("{} {} {}", noun, part.index, part.type), advice_word(part), errors});
  }
  return table.text();
}

std::string advice_text(const Tuning& tuning) {
  const auto& advice = tuning.advice;
  return "the error of the choice when one part alone is changed (nothing was)\n" + parts_text("force", advice.forces) +
         parts_text("contact", advice.contacts) + parts_text("network", advice.networks);
}

std::string nothing_finite_text(const Tuning& tuning) {
  const Findings& found = tuning.findings;
  if (found.trials.empty()) {
    return fmt::format("no candidate was run: the reference took {:.3g} s of the {:g} s of --budget\n",
                       tuning.reference_seconds, tuning.budget);
  }
  const auto count = [&](const auto& is_so) { return std::count_if(found.trials.begin(), found.trials.end(), is_so); };
  const auto refused = count([](const Trial& trial) { return !trial.outcome.refused.empty(); });
  const auto given_up = count([](const Trial& trial) { return trial.outcome.is_cut; });
  return fmt::format(
      "no run reached the goal: {} candidates were run, and none stayed finite; {} were refused, {} given up for want of "
      "time\n",
      static_cast<std::ptrdiff_t>(found.trials.size()) - refused - given_up, refused, given_up);
}

std::string nothing_text(const Tuning& tuning) {
  if (tuning.amplitude == 0) return "nothing moves in this scene: there is no amplitude that an error could be a part of\n";
  if (!tuning.is_judged()) {
    return fmt::format(
        "the reference itself is known to {:.2g} of the amplitude only (halving its steps moves it so far): no run can be\n"
        "judged to {:g}. Chaotic scenes have no path to keep to; a shorter --duration may have.\n",
        tuning.reference.self_error / tuning.amplitude, tuning.goal);
  }
  if (tuning.other_seed) {
    return fmt::format("no run that keeps {:g} keeps it with values drawn by --seed {} too\n", tuning.goal,
                       tuning.other_seed->seed);
  }
  const auto* best = most_accurate(tuning.findings);
  if (best == nullptr) return nothing_finite_text(tuning);
  return fmt::format("no run reached {:g}; the best was {}: {:.3g}\n", tuning.goal, text_of(best->candidate),
                     best->outcome.errors.relative);
}

}  // namespace

std::string to_text(const Tuning& tuning) {
  const auto* choice = tuning.choice();
  if (choice == nullptr) return head_text(tuning) + nothing_text(tuning) + curves_text(tuning);
  return head_text(tuning) + choice_text(tuning, *choice) + exhaustive_text(tuning) + curves_text(tuning) + advice_text(tuning);
}

}  // namespace dvdx::tool::tune
