#include "tune/bench.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "report/sample.hpp"
#include "state/origin.hpp"

namespace dvdx::tool::tune {
namespace {

using report::WallClock;

report::Setup setup_for(const Candidate& candidate, const report::Setup& setup) {
  auto own = setup;
  own.engine.precision = candidate.precision;
  own.engine.arithmetic = candidate.arithmetic.value_or(setup.engine.arithmetic);
  return own;
}

Scene changed(const Scene& scene, const Candidate& candidate, const Judge::Change& change) {
  auto own = scene_of(scene, candidate);
  if (change) change(own);
  return own;
}

// Chooses the origin that `dvdx run` chooses in this precision.
SceneFile file_for(SceneFile file, Precision precision) {
  choose_origin(file, precision);
  return file;
}

// A reference off by a tenth of the goal still shows which runs keep the goal, but not which are far better.
report::Reference reference_for(SceneFile sample, const report::Grid& grid, double goal, const report::Setup& setup) {
  sample.scene.origin = {};  // comparisons are in world coordinates
  const bool is_swept = !sample.scene.networks.empty() || !sample.scene.constraints.empty();
  if (is_swept) {
    auto growing = setup;
    if (setup.end != report::never) growing.end = WallClock::now() + (setup.end - WallClock::now()) / 4;
    const auto growth = report::growth_of(sample, report::steps_of(sample), growing);
    return report::joined_reference(
        sample, grid, report::picks_of(sample.particles.count, 256),
        {.substeps = static_cast<int>(std::lround(grid.coarsest / sample.step)),
         .most_seconds = std::numeric_limits<double>::infinity(),
         .smallest_error = [goal](const report::Reference& reference) { return 10 * goal * reference.amplitude; },
         .growth = growth},
        setup);
  }
  auto reference = report::first_reference(sample, grid, setup);
  report::refine(reference, sample, grid, setup, goal * reference.amplitude, report::Effort::quick);
  return reference;
}

// Extends a report's grid by factors of three and five: chains of rods have their own sub-steps, and take long steps well.
report::Grid grid_for(const SceneFile& sample) {
  auto grid = report::grid_of(sample, sample.particles.count, report::Effort::full);
  if (sample.scene.constraints.empty() || !sample.scene.networks.empty()) return grid;
  constexpr std::uint64_t few = 12;
  for (const std::uint64_t factor : {3U, 5U}) {
    if (grid.coarse_steps % factor != 0 || grid.coarse_steps / factor < few) continue;
    grid.coarse_steps /= factor;
    grid.coarsest *= static_cast<double>(factor);
    grid.halvings += 2;
  }
  grid.counts.resize(std::min<std::uint64_t>(grid.coarse_steps, 100) + 1);
  for (std::uint64_t k = 0; k < grid.counts.size(); ++k) grid.counts[k] = k * grid.coarse_steps / (grid.counts.size() - 1);
  return grid;
}

report::Setup without_end(report::Setup setup) {
  setup.end = report::never;
  return setup;
}

}  // namespace

Judge::Judge(const SceneFile& file, double goal, const report::Setup& setup)
    : setup_(without_end(setup)),
      sample_(report::sample_of(file, 1024)),
      grid_(grid_for(sample_)),
      reference_(reference_for(sample_, grid_, goal, setup)) {
  grid_.counts.resize(reference_.horizon);
}

Outcome Judge::errors(const Candidate& candidate, const Change& change, WallClock::time_point end) const {
  auto setup = setup_for(candidate, setup_);
  setup.end = end;
  const auto file = file_for(sample_, candidate.precision);
  const auto scene = changed(file.scene, candidate, change);
  try {
    return report::with_scalar(candidate.precision, [&](auto zero) -> Outcome {
      using T = decltype(zero);
      return {.errors = report::measure_errors<T>(file, scene, grid_, candidate.parts, reference_, setup).errors};
    });
  } catch (const Fault& fault) {
    return {.errors = {}, .refused = fault.what()};
  } catch (const report::OutOfTime&) {
    return {.errors = {}, .is_cut = true};
  }
}

std::optional<int> Judge::fewest_substeps(const Coupling& coupling, std::uint64_t parts) const {
  Soa<double> memory(sample_.particles.count);
  auto start = memory.view();
  place_at_start(sample_, start);
  Scene scene = sample_.scene;
  scene.coupling = coupling;
  scene.coupling.substeps.reset();
  const auto& engine = setup_.engine;
  const auto plan =
      compile<double>(scene, {.step = grid_.part(parts), .isa = engine.isa, .arithmetic = engine.arithmetic}, start);
  if (!plan || !plan->network_limit()) return std::nullopt;
  return plan->network_limit()->fewest;
}

double Judge::self_error() const { return reference_.facts.self_error / reference_.amplitude; }

class Watch::Track {
 public:
  virtual ~Track() = default;
  virtual Cost time(const Candidate& candidate, const Judge::Change& change, WallClock::time_point end) = 0;

  template <class T>
  class Of;
};

template <class T>
class Watch::Track::Of final : public Track {
 public:
  Of(const SceneFile& file, const report::Grid& grid, const report::Setup& setup)
      : file_(file_for(file, setup.engine.precision)),
        grid_(grid),
        setup_(setup),
        timer_(file_, moments_of(file_.scene), grid_, setup_, report::Effort::quick) {}

  Cost time(const Candidate& candidate, const Judge::Change& change, WallClock::time_point end) override {
    setup_.end = end;
    StateMemory<T> memory(Layout::soa, file_.particles.count, rounding_of(setup_.engine.precision));
    auto start = memory.view();
    place_at_start(file_, start);
    const auto engine = setup_for(candidate, setup_).engine;
    const auto plan = report::compiled(file_, changed(file_.scene, candidate, change), candidate.step, engine, start);
    const double ns = timer_.time(plan, grid_.coarse_steps * candidate.parts).ns_per_particle_step;
    return {.ns_per_particle_step = ns,
            .seconds_per_simulated_second = 1e-9 * ns * static_cast<double>(file_.particles.count) / candidate.step};
  }

 private:
  static Scene moments_of(const Scene& scene) {
    Scene moments = report::with_method(scene, Method::combined);
    moments.coupling.scheme = Scheme::leapfrog;
    if (!scene.networks.empty()) moments.coupling.substeps.reset();
    return moments;
  }

  SceneFile file_;
  const report::Grid& grid_;
  report::Setup setup_;
  report::Timer<T> timer_;
};

Watch::Watch(const SceneFile& file, const report::Grid& grid, const report::Setup& setup)
    : file_(file), grid_(grid), setup_(setup) {}

Watch::~Watch() = default;

Cost Watch::time(const Candidate& candidate, const Judge::Change& change, WallClock::time_point end) {
  auto& track = tracks_[candidate.precision];
  if (track == nullptr) {
    auto setup = setup_;
    setup.engine.precision = candidate.precision;
    report::with_scalar(candidate.precision,
                        [&](auto zero) { track = std::make_unique<Track::Of<decltype(zero)>>(file_, grid_, setup); });
  }
  try {
    return track->time(candidate, change, end);
  } catch (const Fault&) {
    return {};
  } catch (const report::OutOfTime&) {
    return {};
  }
}

Bench::Bench(const Judge& judge, Watch& watch, WallClock::time_point end, WallClock::time_point last, ProgressCallback tell)
    : judge_(judge), watch_(watch), end_(end), last_(last), tell_(std::move(tell)) {}

Outcome Bench::errors(const Candidate& candidate) {
  tell_("error of " + text_of(candidate));
  return judge_.errors(candidate, {}, last_);
}

Cost Bench::rough_cost(const Candidate& candidate) {
  tell_("time of " + text_of(candidate));
  return watch_.time(candidate, {}, last_);
}

std::vector<Cost> Bench::race(const std::vector<Candidate>& candidates) {
  constexpr int rounds = 3;
  std::vector<Cost> least(candidates.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t k = 0; k < candidates.size() && WallClock::now() < last_; ++k) {
      const auto cost = rough_cost(candidates[k]);
      if (cost.ns_per_particle_step == 0) continue;
      const bool is_first = least[k].ns_per_particle_step == 0;
      if (is_first || cost.ns_per_particle_step < least[k].ns_per_particle_step) least[k] = cost;
    }
  }
  return least;
}

}  // namespace dvdx::tool::tune
