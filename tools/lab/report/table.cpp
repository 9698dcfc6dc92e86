#include "report/table.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "output/console.hpp"
#include "report/summary.hpp"
#include "report/text_table.hpp"
#include "scene_io/names.hpp"

namespace dvdx::tool::report {
namespace {

std::string runs_table(const SceneReport& scene) {
  TextTable table(2);
  std::vector<std::string> head{"method", "precision", "order", "theory"};
  for (const double goal : error_goals) head.push_back(fmt::format("{:.0e}", goal));
  head.emplace_back("least error");
  head.emplace_back("its energy error");
  table.row(head);
  for (const auto& cheapest : cheapest_of(scene)) {
    const auto* order = order_of(scene, cheapest.method, cheapest.precision);
    std::vector<std::string> cells{cheapest.method, std::string(name_in(precisions, cheapest.precision)), fitted_text(*order),
                                   theory_text(*order)};
    for (const auto* run : cheapest.runs) cells.push_back(run == nullptr ? "-" : number_text(run->ns_per_particle_second()));
    cells.push_back(number_text(cheapest.best_error));
    cells.push_back(number_text(cheapest.best_energy_drift));
    table.row(cells);
  }
  return table.text();
}

std::string diverged_text(const SceneReport& scene) {
  std::string text;
  for (const auto& cheapest : cheapest_of(scene)) {
    if (cheapest.diverged_steps.empty()) continue;
    std::string steps;
    for (const double step : cheapest.diverged_steps) steps += fmt::format("{}{:.4g}", steps.empty() ? "" : ", ", step);
    text +=
        fmt::format("  DIVERGED: {} in {} at steps of {} s\n", cheapest.method, name_in(precisions, cheapest.precision), steps);
  }
  return text;
}

std::string unranked_text(const SceneReport& scene) {
  std::string text;
  for (const auto& cheapest : cheapest_of(scene)) {
    if (cheapest.unranked == 0) continue;
    text += fmt::format("  NOT RANKED: {} run{} of {} in {}: no nearer than chaos leaves any two starts\n", cheapest.unranked,
                        cheapest.unranked == 1 ? "" : "s", cheapest.method, name_in(precisions, cheapest.precision));
  }
  return text;
}

std::string beyond_text(const SceneReport& scene) {
  const auto& beyond = scene.beyond;
  if (!scene.no_beyond.empty()) return "beyond the horizon nothing is compared: " + scene.no_beyond + "\n";
  if (beyond.starts == 0) return "";
  TextTable table(3);
  std::vector<std::string> head{"method", "precision", "sub-steps"};
  std::vector<std::string> reference{"reference", "float64", ""};
  for (const auto& statistic : beyond.statistics) {
    head.push_back(statistic.unit.empty() ? statistic.name : fmt::format("{}, {}", statistic.name, statistic.unit));
    reference.push_back(fmt::format("{:.4g} +- {:.2g}", statistic.mean, statistic.spread));
  }
  table.row(head);
  table.row(reference);
  for (const auto& run : scene.runs) {
    if (run.beyond.empty()) continue;
    std::vector<std::string> cells{run.method, std::string(name_in(precisions, run.precision)), std::to_string(run.substeps)};
    for (const auto& each : run.beyond) cells.push_back(fmt::format("{:.4g}{}", each.value, each.agrees ? "" : " *"));
    table.row(cells);
  }
  return fmt::format(
             "beyond the horizon, over time; the reference's over {} starts up to {:.1e} m beside, which come {:.2g} m apart; "
             "* "
             "off by more than {:.3g} spreads\n",
             beyond.starts, beyond.nudge, beyond.apart, beyond.most_off) +
         table.text();
}

std::string left_out_text(const SceneReport& scene) {
  std::string text;
  for (const auto& run : scene.left_out) {
    text += fmt::format("  LEFT OUT: {} in {}: {}\n", run.method, name_in(precisions, run.precision), run.why);
  }
  return text;
}

std::string long_run_text(const SceneReport& scene) {
  if (scene.long_run.empty()) return "";
  const auto& first = scene.long_run.front();
  TextTable table(1);
  table.row({"method", "E/E0", "det^n", "by formula", "agrees", "verdict"});
  for (const auto& run : scene.long_run) {
    table.row({run.method, fmt::format("{:.4g}", run.measured), fmt::format("{:.4g}", run.by_matrix),
               fmt::format("{:.4g}", run.by_formula), run.agrees ? "1 %" : "NO", run.verdict});
  }
  return fmt::format("energy after {} steps of Omega h = {}, float64\n{}", first.steps, first.z, table.text());
}

std::string claims_text(const SceneReport& scene) {
  if (scene.claims.empty()) return "";
  TextTable table(2);
  table.row({"Brown's claim", "where", "analysis", "measured", "verdict"});
  std::string last;
  for (const auto& claim : scene.claims) {
    table.row({claim.claim == last ? "" : claim.claim, claim.where, claim.expected, fmt::format("{:.3g}", claim.measured),
               claim.verdict});
    last = claim.claim;
  }
  return "claims (error ratios: largest position error over half a period)\n" + table.text();
}

std::string scene_text(const SceneReport& scene) {
  auto text = fmt::format("\n{}: {} particle{}, {} s, step {:.6g} s, amplitude {:.4g} m\n", printable(scene.scene),
                          scene.particles, scene.particles == 1 ? "" : "s", scene.duration, scene.step, scene.amplitude);
  text += "reference: " + reference_text(scene) + "\n";
  if (const auto horizon = horizon_text(scene); !horizon.empty()) {
    text += "horizon: " + horizon + "; errors, orders and ranks are of that time\n";
  }
  if (scene.error_particles != scene.particles) {
    text += fmt::format("errors on {} evenly spread particles, times on all\n", scene.error_particles);
  }
  text += "ns per particle and simulated second of the cheapest run whose relative error is at most\n";
  text += runs_table(scene) + diverged_text(scene) + unranked_text(scene) + left_out_text(scene) + beyond_text(scene) +
          long_run_text(scene) + claims_text(scene);
  return text;
}

}  // namespace

std::string to_text(const Report& report) {
  const auto& machine = report.machine;
  auto text = fmt::format("dvdx {} on {}, {} cores, {} with {} thread{}; {}\n", machine.version, machine.cpu, machine.cores,
                          machine.isa, machine.threads, machine.threads == 1 ? "" : "s", machine.compiler);
  for (const auto& scene : report.scenes) text += scene_text(scene);
  return text;
}

}  // namespace dvdx::tool::report
