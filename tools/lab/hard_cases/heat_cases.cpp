// Sheets that crumple. Linear stability does not cover them.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "hard_cases/cases.hpp"
#include "hard_cases/trial.hpp"
#include "heat/heat.hpp"
#include "heat/heat_show.hpp"
#include "report/build.hpp"
#include "report/summary.hpp"

namespace dvdx::tool::stability {
namespace {

template <class T>
constexpr Precision precision_of = sizeof(T) == 8 ? Precision::float64 : Precision::float32;

// Takes the first stepping, the default of `sequential`.
template <class T>
void see_heat(CaseRun& way, Setting setting, Worst& worst) {
  setting.precision = precision_of<T>;
  const auto all = steppings();
  const HeatRun run = run_setting(setting, all.front(), way.isa, way.arithmetic);
  way.bits = (way.bits ^ run.bits) * 0x100000001B3U;
  worst.see(run.share, text_of(setting));
}

template <class T>
Worst of_groups(CaseRun& way, std::initializer_list<std::string_view> groups) {
  Worst worst;
  for (const Setting& setting : settings_of(Ensemble::coarse)) {
    if (std::find(groups.begin(), groups.end(), setting.group) != groups.end()) see_heat<T>(way, setting, worst);
  }
  return worst;
}

template <class T>
Worst falling_sheets(CaseRun& way) {
  return of_groups<T>(way, {"falling", "floor", "kicked"});
}
template <class T>
Worst dragged_sheets(CaseRun& way) {
  return of_groups<T>(way, {"damped", "sphere", "dragged"});
}

// Sheets dragged to and fro over a sphere, damped and undamped.
template <class T>
Worst long_drag(CaseRun& way) {
  Worst worst;
  for (const double damping : {0.0, 0.2}) {
    see_heat<T>(way,
                {.group = "dragged",
                 .side = 24,
                 .stiffness = 1e4,
                 .damping = damping,
                 .substeps = 2,
                 .obstacle = Obstacle::sphere,
                 .restitution = 0.3,
                 .pull = 0.5,
                 .pull_seconds = 2,
                 .seed = 44,
                 .frames = 10000},
                worst);
  }
  return worst;
}

// A sheet that stands on its lower edge until it buckles.
SceneFile standing_sheet() {
  Setting setting{.side = 10, .stiffness = 100, .hold = Hold::edge, .precision = Precision::float64, .seed = 58};
  SceneFile file = scene_of(setting, {});
  file.duration = 2;
  file.scene.coupling.substeps.reset();
  for (auto& force : file.scene.forces) {
    if (auto* gravity = std::get_if<Constant>(&force)) gravity->acceleration = {0, 0, -9.81};
  }
  file.scene.add(Drag{.coefficient = 0.001, .wind = {0.1, 0.5, 0}});
  return file;
}

// The difference of leapfrog's fitted order from two. NaN if there is no horizon, if nothing could be fitted, or if a run is
// ranked by chaos alone.
Worst horizon_of_chaos(CaseRun& way) {
  Worst worst;
  const report::Setup setup{.engine = {.precision = Precision::float64, .isa = way.isa, .arithmetic = way.arithmetic},
                            .parallel = {}};
  const report::MeasureOptions options{.precisions = {Precision::float64}, .effort = report::Effort::quick};
  const auto report = report::measure_scene(standing_sheet(), options, setup, [](double, const std::string&) {});
  const auto* order = report::order_of(report, "leapfrog", Precision::float64);
  const bool is_found = !report.reference.horizon.is_whole && report.reference.horizon.by_growth && report.beyond.starts > 0;
  const bool is_ranked_by_chance = std::any_of(report.runs.begin(), report.runs.end(), [&](const report::Run& run) {
    return run.is_ranked && !run.errors.diverged && run.errors.position_rms > report.beyond.apart / 3;
  });
  const bool is_good = is_found && !is_ranked_by_chance && order != nullptr && order->fitted;
  worst.see(is_good ? std::abs(*order->fitted - 2) : std::numeric_limits<double>::quiet_NaN());
  return worst;
}

Bar warmth(std::string_view precision, Check check, std::string_view expected) {
  return {.precision = precision,
          .check = check,
          .limit = heat_bar,
          .unit = "given",
          .expected = expected,
          .runs_on = RunsOn::best_isa};
}

}  // namespace

std::vector<Case> heat_cases() {
  constexpr std::string_view fall = "kinetic energy at most 1.3 of what was given";
  constexpr std::string_view drag = "likewise, the work of the pins counted";
  constexpr std::string_view long_run = "the same over a sphere for 1e4 frames";
  return {{43,
           "falling sheets",
           "directions turn: 1 to 5 sweeps a frame, k = 1e2 to 1e7, grids and meshes, falling, on a floor, thrown",
           {warmth(float64, falling_sheets<double>, fall), warmth(float32, falling_sheets<float>, fall)}},
          {44,
           "dragged sheets",
           "energy is fed in all the time: held particles swing, over a sphere, damped",
           {warmth(float64, dragged_sheets<double>, drag), warmth(float32, dragged_sheets<float>, drag),
            warmth(float64, long_drag<double>, long_run), warmth(float32, long_drag<float>, long_run)}},
          {49,
           "a reference of chaotic cloth",
           "a sheet stands on its edge and buckles: where it then is, is chance",
           {{.check = horizon_of_chaos,
             .limit = 0.2,
             .unit = "",
             .expected = "leapfrog of order 2 within the horizon",
             .runs_on = RunsOn::best_isa}}}};
}

}  // namespace dvdx::tool::stability
