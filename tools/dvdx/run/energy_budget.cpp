#include "run/energy_budget.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "run/air_power.hpp"
#include "run/energy.hpp"

namespace dvdx::tool {
namespace {

// m/s^2, of all particles, `seconds` after the start.
struct Acceleration {
  double seconds;

  Vec3 operator()(const Constant& force) const { return force.acceleration; }
  Vec3 operator()(const Sinusoid& force) const {
    const double sine = std::sin(force.angular_frequency * seconds + force.phase);
    return {force.acceleration[0] * sine, force.acceleration[1] * sine, force.acceleration[2] * sine};
  }
  Vec3 operator()(const Polynomial& force) const {
    Vec3 sum{};
    for (std::size_t k = force.acceleration.size(); k-- > 0;) {
      for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] = sum[axis] * seconds + force.acceleration[k][axis];
    }
    return sum;
  }
  template <class Other>
  Vec3 operator()(const Other& /*force*/) const {
    return {};
  }
};

Vec3 acceleration_at(const Scene& scene, double seconds) {
  Vec3 sum{};
  for (const auto& force : scene.forces) {
    const Vec3 each = std::visit(Acceleration{seconds}, force);
    for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += each[axis];
  }
  return sum;
}

template <class T>
Moments moments_of(const Scene& scene, const State<T>& state) {
  Moments sums;
  sums.air = air_power(scene, state);
  for (std::size_t i = 0; i < state.count; ++i) {
    const double m = scene.mass[i];
    double squares = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto v = static_cast<double>(state.v[axis][i]);
      squares += v * v;
      sums.mass[axis] += m * static_cast<double>(state.x[axis][i]);
      sums.momentum[axis] += m * v;
    }
    sums.kinetic += 0.5 * m * squares;
  }
  for (const auto& force : scene.forces) {
    const auto* drag = std::get_if<Drag>(&force);
    if (drag == nullptr || drag->wind == Vec3{}) continue;
    for (std::size_t i = 0; i < state.count; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        sums.wind += drag->coefficient.at(axis, i) * drag->wind[axis] * static_cast<double>(state.x[axis][i]);
      }
    }
  }
  return sums;
}

// J: every particle at a thousand units in the last place of float32, of the largest distance between particles, a step.
template <class T>
double noise_of(const SceneFile& file, const State<T>& state) {
  double mass = 0;
  double largest = 0;
  for (std::size_t i = 0; i < state.count; ++i) {
    mass += file.scene.mass[i];
    for (const auto& column : state.x) largest = std::max(largest, std::abs(static_cast<double>(column[i] - column[0])));
  }
  const double speed = 1000 * static_cast<double>(std::numeric_limits<float>::epsilon()) * largest / file.step;
  return 0.5 * mass * speed * speed;
}

}  // namespace

template <class T>
EnergyBudget::EnergyBudget(const SceneFile& file, const State<T>& start)
    : file_(file),
      account_{.now = moments_of(file.scene, start), .seconds = start.clock.seconds},
      noise_(noise_of(file, start)) {
  // `energy` is kinetic, the springs', and -a.mx of the constant forces.
  start_ = energy(file, start);
  for (const auto& force : file.scene.forces) {
    const auto* constant = std::get_if<Constant>(&force);
    if (constant == nullptr) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) start_ += constant->acceleration[axis] * account_.now.mass[axis];
  }
}

template <class T>
void EnergyBudget::look(const State<T>& state) {
  auto& [now, seconds, work, most_work] = account_;
  const auto next = moments_of(file_.scene, state);
  const double until = state.clock.seconds;
  const double sixth = (until - seconds) / 6;
  const Vec3 a0 = acceleration_at(file_.scene, seconds);
  const Vec3 a = acceleration_at(file_.scene, 0.5 * (seconds + until));
  const Vec3 a1 = acceleration_at(file_.scene, until);
  // The way is h/6 (p0 + 4 p + p1), the work h/6 (a0 p0 + 4 a p + a1 p1).
  for (std::size_t axis = 0; axis < 3; ++axis) {
    work += a[axis] * (next.mass[axis] - now.mass[axis]);
    work += sixth * ((a0[axis] - a[axis]) * now.momentum[axis] + (a1[axis] - a[axis]) * next.momentum[axis]);
  }
  work += next.wind - now.wind;
  work += 0.5 * (now.air + next.air) * (until - seconds);
  most_work = std::max(most_work, work);
  now = next;
  seconds = until;
}

double EnergyBudget::share() const noexcept {
  const double kinetic = account_.now.kinetic;
  if (std::isnan(kinetic)) return kinetic;
  return kinetic <= noise_ ? 0 : kinetic / std::max(given(), noise_);
}

std::optional<std::uint64_t> steps_between_looks(const SceneFile& file) {
  constexpr double turn = 0.3;  // rad, between looks
  constexpr double coarse = 1;  // rad a step: beyond it the middle stands for nothing
  if (file.scene.networks.empty() || is_live(file) || !(file.step > 0)) return std::nullopt;
  if (has_followers(file.scene)) return std::nullopt;
  double fastest = 0;  // rad a step
  for (const auto& force : file.scene.forces) {
    if (const auto* sine = std::get_if<Sinusoid>(&force)) {
      fastest = std::max(fastest, std::abs(sine->angular_frequency) * file.step);
    }
  }
  double most = 32;  // steps: a look costs a walk over the particles
  if (meets_air(file.scene)) {
    most = 4;
    for (const Gust& gust : file.scene.wind.gusts) fastest = std::max(fastest, std::abs(gust.angular_frequency) * file.step);
  }
  if (fastest > coarse) return std::nullopt;
  return static_cast<std::uint64_t>(fastest * most <= turn ? most : std::max(1.0, turn / fastest));
}

double most_share(const NetworkLimit& limit, double step) noexcept {
  constexpr double bar = 1.3;
  constexpr double most_swing = 10;
  const double part = limit.frequency * step / limit.substeps / limit.limit;  // 0 where there is no limit
  return bar * std::min(most_swing, part < 1 ? 1 / (1 - part * part) : most_swing);
}

template EnergyBudget::EnergyBudget(const SceneFile&, const State<float>&);
template EnergyBudget::EnergyBudget(const SceneFile&, const State<double>&);
template void EnergyBudget::look(const State<float>&);
template void EnergyBudget::look(const State<double>&);

}  // namespace dvdx::tool
