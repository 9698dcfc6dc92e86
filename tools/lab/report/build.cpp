#include "report/build.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "report/baseline.hpp"
#include "report/claims.hpp"
#include "report/long_run.hpp"
#include "report/network_runs.hpp"
#include "report/orders.hpp"
#include "report/sample.hpp"
#include "report/throughput.hpp"
#include "scene_io/names.hpp"
#include "state/origin.hpp"

namespace dvdx::tool::report {
namespace {

// References and plain loops count positions from the world's origin.
SceneFile seen_by_all(SceneFile file) {
  file.scene.origin = {};
  return file;
}

class SceneMeasurement {
 public:
  SceneMeasurement(const SceneFile& file, const MeasureOptions& options, const Setup& setup, const ProgressCallback& progress)
      : file_(file),
        wish_(options),
        setup_(setup),
        tell_(progress),
        sample_(seen_by_all(sample_of(file, most_error_particles(file, options.effort)))),
        grid_(grid_of(file, sample_.particles.count, options.effort)) {}

  SceneReport measure() {
    tell_(0, "reference");
    reference_ = first_reference(sample_, grid_, setup_);
    measure_all_errors();
    if (refine(reference_, sample_, grid_, setup_, smallest_error(), wish_.effort)) measure_all_errors();
    for (const auto precision : wish_.precisions) {
      with_scalar(precision, [&](auto zero) { time_all<decltype(zero)>(precision); });
    }
    return finished();
  }

 private:
  void measure_all_errors() {
    runs_.clear();
    curves_.clear();
    for (const auto precision : wish_.precisions) {
      with_scalar(precision, [&](auto zero) { measure_precision<decltype(zero)>(precision); });
    }
  }

  // The setup of `dvdx run` in this precision. counted() chooses the same origin.
  [[nodiscard]] Setup setup_in(Precision precision) const {
    Setup setup = setup_;
    setup.engine.precision = precision;
    return setup;
  }
  [[nodiscard]] SceneFile counted(SceneFile file, Precision precision) const {
    file.scene.origin = file_.scene.origin;
    choose_origin(file, precision);
    return file;
  }

  template <class T>
  void measure_precision(Precision precision) {
    const auto sample = counted(sample_, precision);
    const auto setup = setup_in(precision);
    for (const auto& [name, method] : methods) {
      for (int halving = 0; halving <= grid_.halvings; ++halving) {
        tell_(0.3 * static_cast<double>(halving) / (grid_.halvings + 1),
              fmt::format("{} {}, errors", name_in(precisions, precision), name));
        const auto parts = std::uint64_t{1} << static_cast<unsigned>(halving);
        const auto measured = measure_errors<T>(sample, with_method(sample.scene, method), grid_, parts, reference_, setup);
        add(std::string(name), precision, halving, measured);
      }
    }
    if (!has_baselines(file_) || precision == Precision::float32_compensated) return;
    for (const auto& [name, baseline] : baselines) {
      for (int halving = 0; halving <= grid_.halvings; ++halving) {
        const auto measured = measure_baseline_errors<T>(sample_, baseline, grid_, halving, reference_, setup_);
        add(std::string(name), precision, halving, measured);
        runs_.back().is_baseline = true;
      }
    }
  }

  void add(const std::string& method, Precision precision, int halving, const Measured& measured) {
    runs_.push_back({.method = method,
                     .is_baseline = false,
                     .precision = precision,
                     .step = grid_.step(halving),
                     .steps = grid_.steps(halving),
                     .isa = std::string(dvdx::name(setup_.engine.isa)),
                     .threads = setup_.engine.threads,
                     .layout = std::string(name_in(layouts, setup_.engine.layout)),
                     .arithmetic = std::string(dvdx::name(setup_.engine.arithmetic)),
                     .errors = measured.errors,
                     .timing = {},
                     .in_fit = false,
                     .order = {}});
    const bool is_own_step = grid_.step(halving) == file_.step;
    if (is_own_step && precision == wish_.precisions.back()) {
      curves_.push_back({.method = method, .times = sample_times(), .energy = measured.energy});
    }
  }

  template <class T>
  void time_all(Precision precision) {
    const auto file = counted(file_, precision);
    const auto setup = setup_in(precision);
    Timer<T> timer(file, grid_, setup, wish_.effort);
    const auto total = static_cast<double>(runs_.size());
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      auto& run = runs_[r];
      if (run.precision != precision) continue;
      tell_(0.3 + 0.7 * static_cast<double>(r) / total,
            fmt::format("{} {}, times", name_in(precisions, precision), run.method));
      const int halving = static_cast<int>(std::lround(std::log2(grid_.coarsest / run.step)));
      if (run.is_baseline) {
        const auto baseline = named(baselines, run.method);
        run.timing = time_baseline<T>(file_, baseline, grid_, halving, setup_, wish_.effort);
        run.threads = 1;
        run.layout = "plain arrays";
        run.isa = baseline_isa(setup_.engine.isa);
      } else {
        run.timing = timer.time(named(methods, run.method), halving);
      }
    }
  }

  [[nodiscard]] double smallest_error() const {
    double smallest = std::numeric_limits<double>::infinity();
    for (const auto& run : runs_) {
      if (!run.errors.diverged) smallest = std::min(smallest, run.errors.position_rms);
    }
    return smallest;
  }

  [[nodiscard]] std::vector<double> sample_times() const {
    std::vector<double> times;
    for (const auto count : grid_.counts) times.push_back(grid_.coarsest * static_cast<double>(count));
    return times;
  }

  SceneReport finished() {
    SceneReport report{.scene = file_.name,
                       .path = file_.path,
                       .about = file_.about,
                       .particles = file_.particles.count,
                       .error_particles = sample_.particles.count,
                       .step = file_.step,
                       .duration = file_.duration,
                       .sample_times = sample_times(),
                       .reference = reference_.facts,
                       .amplitude = reference_.amplitude,
                       .whole_amplitude = reference_.whole_amplitude,
                       .energy_scale = reference_.energy_scale,
                       .keeps_energy = reference_.keeps_energy,
                       .runs = std::move(runs_),
                       .orders = {},
                       .energy_curves = {},
                       .long_run = measure_long_runs(file_, setup_),
                       .claims = {},
                       .throughput = measure_throughput(file_, wish_, setup_, tell_)};
    report.orders = fit_orders(sample_, reference_, report.runs);
    report.energy_curves.push_back({.method = "reference", .times = sample_times(), .energy = reference_.energy});
    for (auto& curve : curves_) report.energy_curves.push_back(std::move(curve));
    report.claims = measure_claims(file_, report.long_run, setup_);
    return report;
  }

  const SceneFile& file_;
  const MeasureOptions& wish_;
  const Setup& setup_;
  const ProgressCallback& tell_;
  SceneFile sample_;
  Grid grid_;
  Reference reference_;
  std::vector<Run> runs_;
  std::vector<EnergyCurve> curves_;
};

}  // namespace

SceneReport measure_scene(const SceneFile& file, const MeasureOptions& options, const Setup& setup,
                          const ProgressCallback& progress) {
  if (!file.scene.networks.empty()) return measure_network_scene(seen_by_all(file), options, setup, progress);
  return SceneMeasurement(file, options, setup, progress).measure();
}

}  // namespace dvdx::tool::report
