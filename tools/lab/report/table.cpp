#include "report/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>

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
  std::vector<std::vector<std::string>> rows;  // rows that differ only in the method are merged
  for (const auto& cheapest : cheapest_of(scene)) {
    const auto* order = order_of(scene, cheapest.method, cheapest.precision);
    std::vector<std::string> cells{cheapest.method, std::string(name_in(precisions, cheapest.precision)), fitted_text(*order),
                                   theory_text(*order)};
    for (const auto* run : cheapest.runs) cells.push_back(run == nullptr ? "-" : number_text(run->ns_per_particle_second()));
    cells.push_back(number_text(cheapest.best_error));
    cells.push_back(number_text(cheapest.best_energy_drift));
    const auto same = std::find_if(rows.begin(), rows.end(), [&](const std::vector<std::string>& row) {
      return std::equal(row.begin() + 1, row.end(), cells.begin() + 1);
    });
    if (same == rows.end()) {
      rows.push_back(std::move(cells));
    } else {
      same->front() += ", " + cells.front();
    }
  }
  for (const auto& row : rows) table.row(row);
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
  std::vector<std::string> runs;
  for (const auto& cheapest : cheapest_of(scene)) {
    if (cheapest.unranked == 0) continue;
    runs.push_back(fmt::format("{} run{} of {} in {}", cheapest.unranked, cheapest.unranked == 1 ? "" : "s", cheapest.method,
                               name_in(precisions, cheapest.precision)));
  }
  if (runs.empty()) return "";
  return fmt::format("  NOT RANKED: {}: no nearer than chaos leaves any two starts\n", fmt::join(runs, ", "));
}

// Runs of a method that agree to the digits shown.
struct BeyondRow {
  std::string method;
  std::set<std::string_view> precisions;
  std::set<int> substeps;
  std::vector<std::string> values;
};

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
  std::vector<BeyondRow> rows;
  for (const auto& run : scene.runs) {
    if (run.beyond.empty()) continue;
    BeyondRow row{
        .method = run.method, .precisions = {name_in(precisions, run.precision)}, .substeps = {run.substeps}, .values = {}};
    for (const auto& each : run.beyond) row.values.push_back(fmt::format("{:.4g}{}", each.value, each.agrees ? "" : " *"));
    const auto same = std::find_if(rows.begin(), rows.end(),
                                   [&](const BeyondRow& r) { return r.method == row.method && r.values == row.values; });
    if (same == rows.end()) {
      rows.push_back(std::move(row));
    } else {
      same->precisions.insert(*row.precisions.begin());
      same->substeps.insert(run.substeps);
    }
  }
  for (const auto& row : rows) {
    std::vector<std::string> cells{row.method, fmt::format("{}", fmt::join(row.precisions, ", ")),
                                   fmt::format("{}", fmt::join(row.substeps, ", "))};
    cells.insert(cells.end(), row.values.begin(), row.values.end());
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
  for (auto first = scene.left_out.begin(); first != scene.left_out.end(); ++first) {
    const auto is_same = [&](const LeftOut& other) { return other.why == first->why; };
    if (std::any_of(scene.left_out.begin(), first, is_same)) continue;
    std::vector<std::string> runs;
    for (const auto& other : scene.left_out) {
      if (is_same(other)) runs.push_back(fmt::format("{} in {}", other.method, name_in(precisions, other.precision)));
    }
    text += fmt::format("  LEFT OUT: {}: {}\n", fmt::join(runs, ", "), first->why);
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
