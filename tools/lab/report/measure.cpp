#include "report/measure.hpp"

#include <algorithm>
#include <cmath>

#include "report/sample.hpp"
#include "report/stopwatch.hpp"
#include "state/origin.hpp"

namespace dvdx::tool::report {

template <class T>
Measured measure_errors(const SceneFile& sample, const Scene& scene, const Grid& grid, std::uint64_t parts,
                        const Reference& reference, const Setup& setup) {
  const auto rounding = rounding_of(setup.engine.precision);
  StateMemory<T> memory(Layout::soa, sample.particles.count, rounding);
  auto state = memory.view();
  place_at_start(sample, state);
  const auto plan = compiled(sample, scene, grid.part(parts), setup.engine, state);
  Comparison comparison(reference, sample);
  std::optional<Soa<double>> world;
  if (is_seen_from_elsewhere(scene, rounding)) world.emplace(sample.particles.count);
  const auto take = [&](std::size_t k) {
    if (!world) return comparison.take(state, k);
    auto seen = world->view();
    to_world(scene, state, seen);
    comparison.take(seen, k);
  };
  take(0);
  for (std::size_t k = 1; k < grid.counts.size(); ++k) {
    advance(plan, state, (grid.counts[k] - grid.counts[k - 1]) * parts, setup);
    take(k);
  }
  return {.errors = comparison.errors(), .energy = comparison.energy()};
}

template <class T>
Timer<T>::Timer(const SceneFile& file, const Grid& grid, const Setup& setup, Effort effort)
    : file_(file),
      grid_(grid),
      setup_(setup),
      effort_(effort),
      start_(setup.engine.layout, file.particles.count, rounding_of(setup.engine.precision)),
      work_(setup.engine.layout, file.particles.count, rounding_of(setup.engine.precision)) {
  auto state = start_.view();
  place_at_start(file, state);
}

template <class T>
Timer<T>::Timer(const SceneFile& file, Scene moments, const Grid& grid, const Setup& setup, Effort effort)
    : Timer(file, grid, setup, effort) {
  moments_scene_ = std::move(moments);
}

template <class T>
Timer<T>::~Timer() = default;

template <class T>
void Timer<T>::run(const Plan<T>& plan, std::uint64_t steps) {
  auto state = work_.view();
  const auto most = steps_per_call(state.count);
  for (std::uint64_t done = 0; done < steps;) {
    const auto now = std::min(most, steps - done);
    advance(plan, state, now, setup_.parallel);
    done += now;
  }
}

template <class T>
void Timer<T>::make_moments() {
  const std::size_t pieces = effort_ == Effort::full ? 4 : 2;
  auto state = work_.view();
  copy_state(start_.view(), state);
  const auto scene = moments_scene_ ? *moments_scene_ : with_method(file_.scene, Method::combined);
  const auto plan = compiled(file_, scene, grid_.coarsest, setup_.engine, state);
  for (std::size_t p = 0; p < pieces; ++p) {
    // The moments are the middles of equal parts of the run.
    const auto until = (2 * p + 1) * grid_.coarse_steps / (2 * pieces);
    const auto before = p == 0 ? 0 : (2 * p - 1) * grid_.coarse_steps / (2 * pieces);
    if (until > before) advance(plan, state, until - before, setup_);
    auto moment = std::make_unique<Buffer>(setup_.engine.layout, state.count, rounding_of(setup_.engine.precision));
    auto view = moment->view();
    copy_state(state, view);
    moments_.push_back(std::move(moment));
    clocks_.push_back(state.clock);
  }
}

template <class T>
Timing Timer<T>::time_whole(const Plan<T>& plan, std::uint64_t steps) {
  const auto prepare = [&] {
    auto state = work_.view();
    copy_state(start_.view(), state);
  };
  prepare();
  run(plan, steps);  // warm-up
  const auto least = least_of(prepare, [&] { run(plan, steps); });
  const double particle_steps = static_cast<double>(file_.particles.count) * static_cast<double>(steps);
  return {.ns_per_particle_step = 1e9 * least.seconds / particle_steps,
          .steps = steps,
          .repeats = least.repeats,
          .whole_run = true};
}

template <class T>
Timing Timer<T>::time_pieces(const Plan<T>& plan, double seconds_per_step, std::uint64_t steps) {
  if (moments_.empty()) make_moments();
  const double budget = effort_ == Effort::full ? 0.25 : 0.05;  // s, for all pieces of a repeat
  const double few = 1;
  const double affordable = budget / seconds_per_step / static_cast<double>(moments_.size());
  const double most = static_cast<double>(std::min(steps_per_call(file_.particles.count), steps));
  const auto piece = static_cast<std::uint64_t>(std::min(std::max(affordable, few), most));
  double seconds = 0;
  int repeats = 0;
  for (std::size_t p = 0; p < moments_.size(); ++p) {
    auto state = work_.view();
    const auto prepare = [&] {
      copy_state(moments_[p]->view(), state);
      state.clock = clocks_[p];
    };
    prepare();
    advance(plan, state, piece, setup_.parallel);  // warm-up
    const auto least = least_of(prepare, [&] { advance(plan, state, piece, setup_.parallel); });
    seconds += least.seconds;
    repeats = p == 0 ? least.repeats : std::min(repeats, least.repeats);
  }
  const auto timed = piece * moments_.size();
  return {.ns_per_particle_step = 1e9 * seconds / (static_cast<double>(file_.particles.count) * static_cast<double>(timed)),
          .steps = timed,
          .repeats = repeats,
          .whole_run = false};
}

template <class T>
Timing Timer<T>::time(Method method, int halving) {
  auto state = work_.view();
  copy_state(start_.view(), state);
  return time(compiled(file_, with_method(file_.scene, method), grid_.step(halving), setup_.engine, state),
              grid_.steps(halving));
}

template <class T>
Timing Timer<T>::time(const Plan<T>& plan, std::uint64_t steps) {
  auto state = work_.view();
  copy_state(start_.view(), state);
  // A rough estimate of the time of a step.
  const auto trial = std::clamp<std::uint64_t>((std::uint64_t{1} << 20U) / state.count, 1, steps);
  constexpr double enough = 0.01;  // s
  const auto before = WallClock::now();
  double spent = 0;
  std::uint64_t done = 0;
  for (std::uint64_t some = 1; done < trial && spent < enough; some *= 2) {
    const auto now = std::min(some, trial - done);
    advance(plan, state, now, setup_);
    done += now;
    spent = std::chrono::duration<double>(WallClock::now() - before).count();
  }
  const double seconds_per_step = spent / static_cast<double>(done);
  const double whole = seconds_per_step * static_cast<double>(steps);
  const double most = effort_ == Effort::full ? 0.3 : 0.05;  // s
  return whole <= most ? time_whole(plan, steps) : time_pieces(plan, seconds_per_step, steps);
}

template Measured measure_errors<float>(const SceneFile&, const Scene&, const Grid&, std::uint64_t, const Reference&,
                                        const Setup&);
template Measured measure_errors<double>(const SceneFile&, const Scene&, const Grid&, std::uint64_t, const Reference&,
                                         const Setup&);
template class Timer<float>;
template class Timer<double>;

}  // namespace dvdx::tool::report
