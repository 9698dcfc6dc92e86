#include "report/reference.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "closed_form/impacts.hpp"
#include "report/sample.hpp"
#include "scene_io/plan_fault.hpp"
#include "watch/energy.hpp"

namespace dvdx::tool::report {
namespace {

double rms_distance(const std::vector<long double>& a, const std::vector<long double>& b) {
  long double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return static_cast<double>(std::sqrt(sum / (static_cast<long double>(a.size()) / 3)));
}

// The distance between the particles of two paths at one sample time; m.
double distance_at(const Path& a, const Path& b, std::size_t time) {
  long double sum = 0;
  for (std::size_t at = a.index(time, 0, 0); at < a.index(time, 0, 0) + 3 * a.particles; ++at) {
    sum += (a.x[at] - b.x[at]) * (a.x[at] - b.x[at]);
  }
  return static_cast<double>(std::sqrt(sum / static_cast<long double>(a.particles)));
}

// Sets the amplitude and the energies of the path.
void describe(Reference& reference, const SceneFile& sample) {
  const auto& path = reference.path;
  reference.horizon = path.times;
  reference.amplitude = reference.whole_amplitude = amplitude_of(path, path.times);
  reference.facts.horizon.seconds = sample.duration;
  reference.keeps_energy = keeps_energy(sample.scene);
  reference.energy.clear();
  reference.energy_scale = 0;
  Soa<double> memory(path.particles);
  auto state = memory.view();
  for (std::size_t k = 0; k < path.times; ++k) {
    double kinetic = 0;
    for (std::size_t i = 0; i < path.particles; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        state.x[axis][i] = static_cast<double>(path.x[path.index(k, i, axis)]);
        state.v[axis][i] = static_cast<double>(path.v[path.index(k, i, axis)]);
        kinetic += 0.5 * sample.scene.mass[i] * state.v[axis][i] * state.v[axis][i];
      }
    }
    reference.energy.push_back(energy(sample, state));
    reference.energy_scale = std::max(reference.energy_scale, kinetic);
  }
}

// The difference between two ways of rounding for up to 64 particles: from sample to sample, and directly from the start.
double rounding_of(const Path& path, const SceneFile& sample, const Grid& grid) {
  const std::size_t particles = std::min<std::size_t>(64, path.particles);
  long double sum = 0;
  std::size_t count = 0;
  for (std::size_t n = 0; n < particles; ++n) {
    const std::size_t i = n * path.particles / particles;
    for (std::size_t k = path.times - 1; k > 0; k /= 2) {
      const auto state =
          exact_state(sample, i, static_cast<long double>(grid.coarsest) * static_cast<long double>(grid.counts[k]));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto off = state[axis].x - path.x[path.index(k, i, axis)];
        sum += off * off;
        // The rounding of the path's own long doubles.
        const auto held = state[axis].x * std::numeric_limits<long double>::epsilon();
        sum += held * held;
      }
      ++count;
    }
  }
  return count == 0 ? 0 : static_cast<double>(std::sqrt(sum / static_cast<long double>(count)));
}

// The path from impact to impact if the scene has one; otherwise `why` gives the reason.
std::optional<Reference> impact_reference(const SceneFile& sample, const Grid& grid, std::string& why) {
  if (has_followers(sample.scene)) {
    why = "motions carry particles or contacts";
    return std::nullopt;
  }
  if (!sample.scene.skins.empty()) {
    why = "skins hold particles";
    return std::nullopt;
  }
  auto found = impact_path(sample, grid.coarsest, grid.counts);
  if (const auto* none = std::get_if<NoImpactPath>(&found)) {
    why = none->why;
    return std::nullopt;
  }
  const auto other = impact_path(sample, grid.coarsest, grid.counts, PathOrigin::displaced);
  if (const auto* none = std::get_if<NoImpactPath>(&other)) {
    why = none->why;
    return std::nullopt;
  }
  Reference reference;
  reference.path = std::move(std::get<ImpactPath>(found).path);
  reference.facts = {.kind = "closed_form",
                     .source = ReferenceSource::impacts,
                     .most_impacts = std::get<ImpactPath>(found).most_impacts,
                     .self_error = rms_distance(reference.path.x, std::get<ImpactPath>(other).path.x),
                     .step = 0,
                     .settled = true};
  return reference;
}

Path stepped_path(const SceneFile& sample, const Grid& grid, int halving, const Setup& setup) {
  Soa<double> memory(sample.particles.count);
  auto start = memory.view();
  place_at_start(sample, start);
  const auto plan = compiled(sample, with_method(sample.scene, Method::combined), grid.step(halving), setup.engine, start);
  const auto picks = picks_of(sample.particles.count, sample.particles.count);
  return path_of(traced(sample, plan, std::uint64_t{1} << static_cast<unsigned>(halving), grid, picks, setup), picks.size(),
                 grid.counts.size());
}

// Fourth order with the given sub-steps in a coarsest step; an error if the scheme refuses them.
Expected<Plan<double>> fourth_order(const SceneFile& file, const Grid& grid, std::optional<int> substeps, const Setup& setup) {
  Scene scene = file.scene;
  scene.coupling.scheme = Scheme::fourth_order;
  scene.coupling.substeps = substeps;
  Soa<double> memory(file.particles.count);
  auto start = memory.view();
  place_at_start(file, start);
  return compile<double>(scene, {.step = grid.coarsest, .isa = setup.engine.isa, .arithmetic = setup.engine.arithmetic}, start);
}

Trace fourth_order_trace(const SceneFile& file, const Grid& grid, std::optional<int> substeps, const Picks& picks,
                         const Setup& setup, const Nudge& nudge = {}) {
  const auto plan = fourth_order(file, grid, substeps, setup);
  if (!plan) throw fault_of(file, plan.error());
  return traced(file, *plan, 1, grid, picks, setup, nudge);
}

void take(const Trace& trace, Reference& reference) {
  reference.path = path_of(trace, reference.picks.size(), trace.energy.size());
  reference.energy = trace.energy;
  reference.energy_scale = *std::max_element(trace.kinetic.begin(), trace.kinetic.end());
  reference.horizon = trace.energy.size();
  reference.amplitude = reference.whole_amplitude = amplitude_of(reference.path, reference.horizon);
}

// Replaces the reference's trace by a finer one, as far as that goes. Returns the distance between the two.
double refine_with(const Trace& trace, const Grid& within, Reference& reference) {
  const std::size_t times = within.counts.size();
  const auto finer = path_of(trace, reference.picks.size(), times);
  const double moved = distance(finer, reference.path, times);
  std::copy(finer.x.begin(), finer.x.end(), reference.path.x.begin());
  std::copy(finer.v.begin(), finer.v.end(), reference.path.v.begin());
  std::copy(trace.energy.begin(), trace.energy.end(), reference.energy.begin());
  return moved;
}

Grid first_times(Grid grid, std::size_t times) {
  grid.counts.resize(times);
  return grid;
}

void set_horizon(Reference& reference, const Growth& growth, const SceneFile& file, const Grid& grid, std::size_t times) {
  auto& horizon = reference.facts.horizon;
  reference.horizon = times;
  horizon.is_whole = times == grid.counts.size();
  horizon.seconds = grid.coarsest * static_cast<double>(grid.counts[times - 1]);
  for (std::size_t k = 0; k < growth.at.size(); ++k) {
    if (file.step * static_cast<double>(growth.counts[k]) <= horizon.seconds * (1 + 1e-9)) horizon.growth = growth.at[k];
  }
  reference.amplitude = amplitude_of(reference.path, times);
}

constexpr std::size_t fewest_within = 2;  // sample times, including the start

// Sets the horizon to the last sample time before a difference of the start has grown too much.
void end_by_growth(Reference& reference, const Growth& growth, const SceneFile& file, const Grid& grid) {
  std::size_t times = reference.horizon;
  const double last = file.step * static_cast<double>(growth.horizon) * (1 + 1e-9);
  while (!growth.is_whole && times > fewest_within && grid.coarsest * static_cast<double>(grid.counts[times - 1]) > last)
    --times;
  reference.facts.horizon.by_growth = times < reference.horizon;
  reference.facts.horizon.nudge = growth.nudge;
  set_horizon(reference, growth, file, grid, times);
}

// Sets the horizon to the last sample time until which the coarser reference was within a hundredth of the smallest error.
void end_where_in_doubt(Reference& reference, const Path& coarser, const SceneFile& file, const Grid& grid,
                        const Fineness& fineness) {
  const auto is_settled = [&](std::size_t times) {
    reference.horizon = times;
    return distance(coarser, reference.path, times) < fineness.smallest_error(reference) / 100;
  };
  const std::size_t before = reference.horizon;
  std::size_t times = before;
  while (times > fewest_within && !is_settled(times)) --times;
  reference.facts.settled = is_settled(times);
  if (!reference.facts.settled) times = before;
  reference.facts.horizon.by_growth = reference.facts.horizon.by_growth && times == before;
  set_horizon(reference, fineness.growth, file, grid, times);
  reference.facts.self_error = distance(coarser, reference.path, times);
}

int halving_of(const Reference& reference, const Grid& grid) {
  return static_cast<int>(std::lround(std::log2(grid.coarsest / reference.facts.step)));
}

// An eighth of the time: two finer runs take two and four times as long.
Setup with_part_of_time(Setup setup) {
  if (setup.end != never) setup.end = WallClock::now() + (setup.end - WallClock::now()) / 8;
  return setup;
}

constexpr int beyond_the_finest = 2;  // halvings

}  // namespace

Trace reference_trace(const SceneFile& file, const Grid& grid, const Picks& picks, const Nudge& nudge, const Setup& setup) {
  return fourth_order_trace(file, grid, std::nullopt, picks, setup, nudge);
}

double amplitude_of(const Path& path, std::size_t times) {
  long double sum = 0;
  for (std::size_t i = 0; i < path.particles; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      long double mean = 0;
      for (std::size_t k = 0; k < times; ++k) mean += path.x[path.index(k, i, axis)] / static_cast<long double>(times);
      for (std::size_t k = 0; k < times; ++k) {
        const auto off = path.x[path.index(k, i, axis)] - mean;
        sum += off * off;
      }
    }
  }
  return static_cast<double>(std::sqrt(sum / static_cast<long double>(path.particles * times)));
}

double distance(const Path& a, const Path& b) { return distance(a, b, a.times); }

double distance(const Path& a, const Path& b, std::size_t times) {
  long double sum = 0;
  for (std::size_t k = 0; k < times; ++k) {
    const double each = distance_at(a, b, k);
    sum += static_cast<long double>(each) * each;
  }
  return static_cast<double>(std::sqrt(sum / static_cast<long double>(times)));
}

bool keeps_energy(const Scene& scene) {
  const auto keeps = [](const auto& force) {
    using Type = std::decay_t<decltype(force)>;
    if constexpr (requires { force.damping; }) return force.damping == 0;
    return std::is_same_v<Type, Constant>;
  };
  const auto is_undamped = [](const auto& network) { return network.damping == 0 && !network.aerodynamics; };
  const auto is_elastic = [](const auto& contact) {
    return contact.restitution == 1 && contact.friction == 0 && contact.viscosity == 0 && contact.normal_viscosity == 0;
  };
  const bool keeps_in_meetings = !scene.meet || (scene.meet->restitution == 1 && scene.meet->friction == 0);
  return keeps_in_meetings && !has_followers(scene) && scene.skins.empty() && scene.tethers.empty() &&
         std::all_of(scene.networks.begin(), scene.networks.end(),
                     [&](const Network& n) { return std::visit(is_undamped, n); }) &&
         std::all_of(scene.forces.begin(), scene.forces.end(), [&](const Force& f) { return std::visit(keeps, f); }) &&
         std::all_of(scene.contacts.begin(), scene.contacts.end(), [&](const Contact& c) { return std::visit(is_elastic, c); });
}

Reference first_reference(const SceneFile& sample, const Grid& grid, const Setup& setup) {
  Reference reference;
  std::string why;
  if (closed_form_of(sample) != ClosedForm::none) {
    reference.path = exact_path(sample, grid.coarsest, grid.counts);
    reference.facts = {.kind = "closed_form",
                       .source = ReferenceSource::formula,
                       .self_error = rounding_of(reference.path, sample, grid),
                       .step = 0,
                       .settled = true};
  } else if (auto found = impact_reference(sample, grid, why)) {
    reference = std::move(*found);
  } else {
    const int halving = grid.halvings + beyond_the_finest;
    const auto coarser = stepped_path(sample, grid, halving - 1, setup);
    reference.path = stepped_path(sample, grid, halving, setup);
    reference.facts = {.kind = "extrapolated",
                       .source = ReferenceSource::finer_steps,
                       .no_closed_form = why,
                       .self_error = rms_distance(coarser.x, reference.path.x),
                       .step = grid.step(halving),
                       .settled = false};
  }
  reference.picks = picks_of(sample.particles.count, sample.particles.count);
  describe(reference, sample);
  return reference;
}

bool refine(Reference& reference, const SceneFile& sample, const Grid& grid, const Setup& setup, double smallest_error,
            Effort effort) {
  if (reference.facts.source == ReferenceSource::impacts) {
    // Every impact amplifies the rounding of long doubles. If the runs agree with the reference to the last digit, nothing
    // finer can be resolved.
    constexpr double digits = 1e-15;
    reference.facts.settled = reference.facts.self_error < std::max(smallest_error / 100, digits * reference.amplitude);
  }
  if (reference.facts.kind == "closed_form") return false;
  const double most_work = effort == Effort::full ? 4e8 : 1e8;  // particle-steps
  const auto work = [&](int halving) {
    return static_cast<double>(sample.particles.count) * static_cast<double>(grid.steps(halving));
  };
  bool changed = false;
  int halving = halving_of(reference, grid);
  reference.facts.settled = reference.facts.self_error < smallest_error / 100;
  while (!reference.facts.settled && work(halving + 1) <= most_work) {
    ++halving;
    auto finer = stepped_path(sample, grid, halving, setup);
    reference.facts.self_error = rms_distance(finer.x, reference.path.x);
    reference.facts.step = grid.step(halving);
    reference.facts.settled = reference.facts.self_error < smallest_error / 100;
    reference.path = std::move(finer);
    changed = true;
  }
  if (changed) describe(reference, sample);
  return changed;
}

Reference joined_reference(const SceneFile& file, const Grid& grid, const Picks& picks, const Fineness& fineness,
                           const Setup& setup) {
  if (closed_form_of(file) != ClosedForm::none) return first_reference(file, grid, setup);
  constexpr int most_substeps = 500000;
  Reference reference;
  reference.keeps_energy = keeps_energy(file.scene);
  reference.picks = picks;
  int substeps = fineness.substeps;
  if (const auto own = fourth_order(file, grid, std::nullopt, setup); own && own->network_limit()) {
    substeps = std::max(substeps, own->network_limit()->fewest);
  }
  auto last = fourth_order_trace(file, grid, substeps, picks, with_part_of_time(setup));
  take(last, reference);
  double spent = last.seconds;
  reference.facts = {.kind = "extrapolated", .source = ReferenceSource::finer_steps, .step = grid.coarsest, .settled = false};
  end_by_growth(reference, fineness.growth, file, grid);
  auto within = first_times(grid, reference.horizon);
  Path coarser;
  double moved = std::numeric_limits<double>::infinity();
  bool helps = true;
  do {
    substeps *= 2;
    last = fourth_order_trace(file, within, substeps, picks, setup);
    spent += last.seconds;
    if (last.energy.size() < within.counts.size()) {
      within = first_times(std::move(within), last.energy.size());
      set_horizon(reference, fineness.growth, file, grid, within.counts.size());
    }
    coarser = reference.path;
    const double before = std::exchange(moved, refine_with(last, within, reference));
    helps = moved < before / 2;
    reference.facts.self_error = moved;
    reference.facts.substeps = substeps;
    reference.facts.settled = moved < fineness.smallest_error(reference) / 100;
  } while (!reference.facts.settled && helps && substeps <= most_substeps && spent + 2 * last.seconds < fineness.most_seconds &&
           setup.end - WallClock::now() > std::chrono::duration<double>(2 * last.seconds));
  if (!reference.facts.settled) end_where_in_doubt(reference, coarser, file, grid, fineness);
  reference.amplitude = amplitude_of(reference.path, reference.horizon);
  return reference;
}

}  // namespace dvdx::tool::report
