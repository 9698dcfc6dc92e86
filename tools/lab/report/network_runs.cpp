#include "report/network_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "dvdx/layouts/soa.hpp"
#include "report/beyond.hpp"
#include "report/curves.hpp"
#include "report/measure.hpp"
#include "report/orders.hpp"
#include "scene_io/names.hpp"
#include "scene_io/plan_fault.hpp"

namespace dvdx::tool::report {
namespace {

Scene with_coupling(const SceneFile& file, Coupling coupling, std::optional<int> substeps) {
  Scene scene = file.scene;
  coupling.substeps = substeps;
  scene.coupling = coupling;
  return scene;
}

class NetworkMeasurement {
 public:
  NetworkMeasurement(const SceneFile& file, const MeasureOptions& options, const Setup& setup, const ProgressCallback& progress)
      : file_(file),
        wish_(options),
        setup_(setup),
        tell_(progress),
        growth_(growth_of(file, steps_of(file), setup)),
        grid_(own_step(file, growth_)),
        picks_(picks_of(file.particles.count, 256)) {}

  SceneReport measure() {
    auto curves = curves_of(file_);
    for (auto& race : races_of(file_, setup_.engine.arithmetic)) curves.push_back(std::move(race));
    for (std::size_t c = 0; c < curves.size(); ++c) {
      for (const auto& entry : precisions) {
        const auto precision = entry.value;
        if (std::find(wish_.precisions.begin(), wish_.precisions.end(), precision) == wish_.precisions.end()) continue;
        tell_(0.8 * static_cast<double>(c) / static_cast<double>(curves.size()),
              fmt::format("{} {}", entry.name, curves[c].name));
        with_scalar(precision, [&](auto zero) { run_curve<decltype(zero)>(curves[c], precision); });
      }
    }
    tell_(0.8, "reference");
    make_reference();
    for (std::size_t r = 0; r < runs_.size(); ++r) compare(r);
    refine_note();
    tell_(0.95, "beyond the horizon");
    look_beyond();
    return finished();
  }

 private:
  // The step stays the scene's own; the sub-steps vary. If there is a horizon, half of the samples lie within it.
  static Grid own_step(const SceneFile& file, const Growth& growth) {
    const auto steps = steps_of(file);
    constexpr std::uint64_t most = 60;
    Grid grid{.coarsest = file.step, .coarse_steps = steps, .halvings = 0, .counts = {0}};
    const auto spread = [&](std::uint64_t until, std::uint64_t samples_at_most) {
      const auto from = grid.counts.back();
      const auto samples = std::min(samples_at_most, until - from);
      for (std::uint64_t k = 1; k <= samples; ++k) grid.counts.push_back(from + k * (until - from) / samples);
    };
    if (growth.is_whole) {
      spread(steps, most);
    } else {
      spread(std::max<std::uint64_t>(growth.horizon, 1), most / 2);
      spread(steps, most / 2);
    }
    return grid;
  }

  // The limit of a run's time; longer runs are left out.
  [[nodiscard]] double most_seconds() const { return wish_.effort == Effort::full ? 60 : 3; }

  // With LongRuns::whole, one run of each curve is compared beyond the horizon, however long it takes.
  [[nodiscard]] bool is_asked_for(const Curve& curve, const NetworkLimit& limit, int substeps) const {
    return wish_.long_runs == LongRuns::whole && !curve.arithmetic && substeps == usual_substeps(curve.coupling, limit);
  }

  // The predicted seconds of a whole run: from `own` seconds a sub-step or, if that is 0, from the slowest kind of run so far.
  [[nodiscard]] double predicted(const Coupling& coupling, int substeps, double own) const {
    const double each = own > 0 ? own : pulses_of(coupling) * seconds_per_pulse_;
    return each * substeps * static_cast<double>(grid_.coarse_steps);
  }

  template <class T>
  [[nodiscard]] Expected<Plan<T>> compiled_with(const Curve& curve, std::optional<int> substeps) const {
    Soa<T> memory(file_.particles.count);
    auto state = memory.view();
    place_at_start(file_, state);
    return compile<T>(with_coupling(file_, curve.coupling, substeps),
                      {.step = file_.step, .isa = setup_.engine.isa, .arithmetic = arithmetic_of(curve)}, state);
  }
  [[nodiscard]] Arithmetic arithmetic_of(const Curve& curve) const {
    return curve.arithmetic.value_or(setup_.engine.arithmetic);
  }

  template <class T>
  void run_curve(const Curve& curve, Precision precision) {
    const auto leave_out = [&](const std::string& why) {
      left_out_.push_back({.method = curve.name, .precision = precision, .why = why});
    };
    if (precision == Precision::float32_compensated) return leave_out("joined particles are reported in float32 and float64");
    const auto own = compiled_with<T>(curve, std::nullopt);
    if (!own) return leave_out(in_words_of(file_, own.error()).message());
    const auto limit = own->network_limit();
    if (!limit) return leave_out("nothing is joined");
    double seconds_each = 0;
    for (const int substeps : substeps_of(curve, *limit, wish_.effort)) {
      const double whole = predicted(curve.coupling, substeps, seconds_each);
      const bool is_asked = is_asked_for(curve, *limit, substeps);
      const bool is_whole = growth_.is_whole || whole <= most_seconds() || runs_.empty() || is_asked;
      const Grid grid = is_whole ? grid_ : until_horizon();
      const double seconds = whole * static_cast<double>(grid.counts.back()) / static_cast<double>(grid_.coarse_steps);
      if (seconds > most_seconds() && !runs_.empty() && !is_asked) {
        return leave_out(fmt::format("{} sub-steps and more: a run {}would take {:.0f} s", substeps,
                                     is_whole ? "" : "until the horizon ", seconds));
      }
      const auto plan = compiled_with<T>(curve, substeps);
      if (!plan) {
        leave_out(in_words_of(file_, plan.error()).message());
        continue;
      }
      auto made = traced(file_, *plan, 1, grid, picks_, setup_);
      const auto spent = made.seconds / substeps / static_cast<double>(grid.counts.back());
      seconds_each = spent;
      seconds_per_pulse_ = std::max(seconds_per_pulse_, spent / pulses_of(curve.coupling));
      add(curve, precision, substeps, timing(*plan, made, grid.counts.back()));
      const bool is_usual = is_whole && !curve.arithmetic && substeps == usual_substeps(curve.coupling, *limit);
      if (is_usual && precision == wish_.precisions.back()) {
        energy_curves_.push_back({.method = curve.name, .times = sample_times(), .energy = made.energy});
      }
      traces_.push_back(std::move(made));
    }
  }

  // The grid of a run that would take too long: until the horizon only.
  [[nodiscard]] Grid until_horizon() const {
    Grid grid = grid_;
    const auto horizon = std::max<std::uint64_t>(growth_.horizon, 1);
    std::erase_if(grid.counts, [&](std::uint64_t count) { return count > horizon; });
    return grid;
  }

  // A long run, of `steps`, was already timed while it was traced.
  template <class T>
  [[nodiscard]] Timing timing(const Plan<T>& plan, const Trace& made, std::uint64_t steps) const {
    constexpr double long_run = 2;  // s
    const auto count = static_cast<double>(file_.particles.count);
    if (made.seconds > (wish_.effort == Effort::full ? long_run : long_run / 8)) {
      return {.ns_per_particle_step = 1e9 * made.seconds / (count * static_cast<double>(steps)),
              .steps = steps,
              .repeats = 1,
              .whole_run = steps == grid_.coarse_steps};
    }
    auto moments = with_coupling(file_, file_.scene.coupling, std::nullopt);
    moments.coupling.scheme = Scheme::leapfrog;
    Timer<T> timer(file_, std::move(moments), grid_, setup_, wish_.effort);
    return timer.time(plan, grid_.coarse_steps);
  }

  void add(const Curve& curve, Precision precision, int substeps, const Timing& timing) {
    runs_.push_back({.method = curve.name,
                     .is_baseline = false,
                     .precision = precision,
                     .step = file_.step,
                     .steps = grid_.coarse_steps,
                     .substeps = substeps,
                     .coupled = described(file_, curve),
                     .isa = std::string(dvdx::name(setup_.engine.isa)),
                     .threads = setup_.engine.threads,
                     .layout = std::string(name_in(layouts, setup_.engine.layout)),
                     .arithmetic = std::string(dvdx::name(arithmetic_of(curve))),
                     .errors = {},
                     .timing = timing,
                     .in_fit = false,
                     .order = {}});
  }

  // ---- the reference ---------------------------------------------------------------------------------------------------

  // The reference begins with at least as many sub-steps as the finest run of fourth_order shown.
  void make_reference() {
    int substeps = 1;
    for (const auto& run : runs_) {
      if (run.method == "fourth_order") substeps = std::max(substeps, run.substeps);
    }
    reference_ = joined_reference(file_, grid_, picks_,
                                  {.substeps = substeps,
                                   .most_seconds = wish_.effort == Effort::full ? 300.0 : 10.0,
                                   .smallest_error = [this](const Reference& reference) { return smallest_error(reference); },
                                   .growth = growth_},
                                  setup_);
  }

  // The smallest error of the runs relative to the present reference.
  [[nodiscard]] double smallest_error(const Reference& reference) const {
    double smallest = std::numeric_limits<double>::infinity();
    for (const auto& made : traces_) {
      const double error = distance(path_of(made, picks_.size(), made.energy.size()), reference.path, reference.horizon);
      if (std::isfinite(error)) smallest = std::min(smallest, error);
    }
    return smallest;
  }

  // ---- errors ----------------------------------------------------------------------------------------------------------

  void compare(std::size_t r) {
    const auto& made = traces_[r];
    Comparison comparison(reference_, file_);
    Soa<double> memory(file_.particles.count);
    auto state = memory.view();
    for (std::size_t k = 0; k < made.energy.size(); ++k) {
      for (std::size_t n = 0; n < picks_.size(); ++n) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const auto at = (k * picks_.size() + n) * 3 + axis;
          state.x[axis][picks_[n]] = made.x[at];
          state.v[axis][picks_[n]] = made.v[at];
        }
      }
      comparison.take(state, k, made.energy[k]);
    }
    runs_[r].errors = comparison.errors();
  }

  // The smallest error shown may have changed since the reference was made.
  void refine_note() {
    if (reference_.facts.kind == "closed_form") return;
    double smallest = std::numeric_limits<double>::infinity();
    for (const auto& run : runs_) {
      if (!run.errors.diverged) smallest = std::min(smallest, run.errors.position_rms);
    }
    reference_.facts.settled = reference_.facts.self_error < smallest / 100;
  }

  // ---- beyond the horizon ----------------------------------------------------------------------------------------------

  // A run is not ranked if its error is at least a third of the distance between two starts: chaos decides the order of such
  // runs.
  void look_beyond() {
    const double most = wish_.long_runs == LongRuns::whole ? std::numeric_limits<double>::infinity() : most_seconds();
    scatter_ = scatter_beyond(file_, grid_, reference_, wish_.effort, most, setup_);
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      auto& run = runs_[r];
      if (scatter_.facts.starts == 0 || run.errors.diverged) continue;
      const bool is_whole = traces_[r].energy.size() == grid_.counts.size();
      if (is_whole) run.beyond = beside(scatter_, statistics_of(traces_[r], reference_.horizon));
      run.is_ranked = !reference_.facts.horizon.by_growth || run.errors.position_rms < scatter_.facts.apart / 3;
    }
  }

  [[nodiscard]] std::vector<double> sample_times() const {
    std::vector<double> times;
    for (const auto count : grid_.counts) times.push_back(file_.step * static_cast<double>(count));
    return times;
  }

  [[nodiscard]] GrowthCurve growth_curve() const {
    GrowthCurve curve{.times = {}, .growth = growth_.at};
    for (const auto count : growth_.counts) curve.times.push_back(file_.step * static_cast<double>(count));
    return curve;
  }

  SceneReport finished() {
    SceneReport report{.scene = file_.name,
                       .path = file_.path,
                       .about = file_.about,
                       .particles = file_.particles.count,
                       .error_particles = picks_.size(),
                       .step = file_.step,
                       .duration = file_.duration,
                       .sample_times = sample_times(),
                       .reference = reference_.facts,
                       .growth = growth_curve(),
                       .beyond = scatter_.facts,
                       .no_beyond = scatter_.why,
                       .amplitude = reference_.amplitude,
                       .whole_amplitude = reference_.whole_amplitude,
                       .energy_scale = reference_.energy_scale,
                       .keeps_energy = reference_.keeps_energy,
                       .runs = std::move(runs_),
                       .left_out = std::move(left_out_),
                       .orders = {},
                       .energy_curves = {},
                       .long_run = {},
                       .claims = {}};
    report.orders = fit_orders(file_, reference_, report.runs);
    report.energy_curves.push_back({.method = "reference", .times = sample_times(), .energy = reference_.energy});
    for (auto& curve : energy_curves_) report.energy_curves.push_back(std::move(curve));
    return report;
  }

  const SceneFile& file_;
  const MeasureOptions& wish_;
  const Setup& setup_;
  const ProgressCallback& tell_;
  Growth growth_;
  Grid grid_;
  Picks picks_;
  double seconds_per_pulse_ = 0;  // s, all particles
  Reference reference_;
  Scatter scatter_;
  std::vector<Run> runs_;
  std::vector<Trace> traces_;  // one for each run
  std::vector<LeftOut> left_out_;
  std::vector<EnergyCurve> energy_curves_;
};

}  // namespace

SceneReport measure_network_scene(const SceneFile& file, const MeasureOptions& options, const Setup& setup,
                                  const ProgressCallback& progress) {
  return NetworkMeasurement(file, options, setup, progress).measure();
}

}  // namespace dvdx::tool::report
