#include "report/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

namespace dvdx::tool::report {
namespace {

void take(const Run& run, Cheapest& cheapest) {
  if (run.errors.diverged) {
    cheapest.diverged_steps.push_back(run.substep());
    return;
  }
  if (!run.is_ranked) {
    ++cheapest.unranked;
    return;
  }
  if (run.errors.relative < cheapest.best_error) {
    cheapest.best_error = run.errors.relative;
    cheapest.best_energy_drift = run.errors.energy_drift;
  }
  for (std::size_t g = 0; g < error_goals.size(); ++g) {
    if (!(run.errors.relative <= error_goals[g])) continue;
    const auto* best = cheapest.runs[g];
    if (best == nullptr || run.ns_per_particle_second() < best->ns_per_particle_second()) cheapest.runs[g] = &run;
  }
}

// A file name may have 255 bytes; a suffix for the contents is appended to this one.
constexpr std::size_t longest_name = 100;

std::string plain_name(const std::string& text) {
  std::string name;
  for (const char c : text) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) != 0 && static_cast<unsigned char>(c) < 128;
    if (is_plain)
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!name.empty() && name.back() != '-')
      name += '-';
  }
  name.resize(std::min(name.size(), longest_name));
  while (!name.empty() && name.back() == '-') name.pop_back();
  return name.empty() ? "scene" : name;
}

}  // namespace

std::vector<Cheapest> cheapest_of(const SceneReport& scene) {
  std::vector<Cheapest> all;
  for (const auto& run : scene.runs) {
    const auto is_same = [&](const Cheapest& c) { return c.method == run.method && c.precision == run.precision; };
    auto found = std::find_if(all.begin(), all.end(), is_same);
    if (found == all.end()) {
      constexpr double none = std::numeric_limits<double>::infinity();
      all.push_back({.method = run.method,
                     .precision = run.precision,
                     .runs = {},
                     .best_error = none,
                     .best_energy_drift = none,
                     .diverged_steps = {}});
      found = all.end() - 1;
    }
    take(run, *found);
  }
  return all;
}

const Order* order_of(const SceneReport& scene, const std::string& method, Precision precision) {
  for (const auto& order : scene.orders) {
    if (order.method == method && order.precision == precision) return &order;
  }
  return nullptr;
}

std::string fitted_text(const Order& order) {
  if (order.fitted) return fmt::format("{:.2f}", *order.fitted);
  return order.note == "exact" ? "exact" : "-";
}

std::string theory_text(const Order& order) {
  if (order.theory) return fmt::format("{:g}", *order.theory);
  return order.note == "exact" ? "exact" : "-";
}

std::string number_text(double value) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  if (value != 0 && (size >= 1e5 || size < 1e-2)) return fmt::format("{:.1e}", value);
  return size >= 100 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

bool is_coupled(const SceneReport& scene) { return !scene.runs.empty() && scene.runs.front().coupled; }

std::string reference_text(const SceneReport& scene) {
  const auto& reference = scene.reference;
  std::string text;
  switch (reference.source) {
    case ReferenceSource::formula:
      text = fmt::format("closed form in long double, its own error {:.1e} m", reference.self_error);
      break;
    case ReferenceSource::impacts:
      text =
          fmt::format("closed form from impact to impact in long double, up to {} impacts a particle, its own error {:.1e} m",
                      reference.most_impacts, reference.self_error);
      break;
    case ReferenceSource::finer_steps:
      text = fmt::format(
          "the same kernel at finer steps ({} in float64, {:.2e} s), which a wrong law would not show against; halving moved "
          "it "
          "by {:.1e} m",
          is_coupled(scene) ? "scheme fourth_order" : "method combined", reference.step / reference.substeps,
          reference.self_error);
      break;
  }
  if (!reference.settled) text += ", which is MORE than a hundredth of the smallest error shown";
  if (!reference.no_closed_form.empty()) text += "; no closed form: " + reference.no_closed_form;
  return text;
}

std::string horizon_text(const SceneReport& scene) {
  const auto& horizon = scene.reference.horizon;
  if (horizon.is_whole) return "";
  const auto until = fmt::format("{:.4g} s of {:.4g} s", horizon.seconds, scene.duration);
  if (!horizon.by_growth) return until + ", until which the reference is no more in doubt than that";
  return fmt::format("{}, in which a difference of the start grows {:.3g} times", until, horizon.growth);
}

std::vector<std::string> file_names(const Report& report) {
  std::vector<std::string> names;
  for (const auto& scene : report.scenes) {
    const auto base = plain_name(scene.scene);
    auto name = base;
    for (int n = 2; std::find(names.begin(), names.end(), name) != names.end(); ++n) name = fmt::format("{}-{}", base, n);
    names.push_back(name);
  }
  return names;
}

}  // namespace dvdx::tool::report
