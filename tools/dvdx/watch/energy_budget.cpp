#include "watch/energy_budget.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "ranks/agree.hpp"
#include "watch/energy.hpp"

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
  // Springs store energy, and drag takes it; Moments::wind holds the wind's part.
  Vec3 operator()(const Spring& /*force*/) const { return {}; }
  Vec3 operator()(const RadialSpring& /*force*/) const { return {}; }
  Vec3 operator()(const Drag& /*force*/) const { return {}; }
};

Vec3 acceleration_at(const Scene& scene, double seconds) {
  Vec3 sum{};
  for (const auto& force : scene.forces) {
    const Vec3 each = std::visit(Acceleration{seconds}, force);
    for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += each[axis];
  }
  return sum;
}

// Sums particle by particle: each of several ranks continues the sums of the ranks before it.
template <class T>
Moments moments_of(const Scene& scene, const State<T>& state, const Held& held, double air) {
  auto all = in_turn(held.ranks, Moments{.air = air}, [&](Moments sums) {
    for (std::size_t k = 0; k < state.count; ++k) {
      const double m = scene.mass[held.first + k];
      double squares = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto v = static_cast<double>(state.v[axis][k]);
        squares += v * v;
        sums.mass[axis] += m * static_cast<double>(state.x[axis][k]);
        sums.momentum[axis] += m * v;
      }
      sums.kinetic += 0.5 * m * squares;
    }
    return sums;
  });
  for (const auto& force : scene.forces) {
    const auto* drag = std::get_if<Drag>(&force);
    if (drag == nullptr || drag->wind == Vec3{}) continue;
    all.wind = in_turn(held.ranks, all.wind, [&](double wind) {
      for (std::size_t k = 0; k < state.count; ++k) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          wind += drag->coefficient.at(axis, held.first + k) * drag->wind[axis] * static_cast<double>(state.x[axis][k]);
        }
      }
      return wind;
    });
  }
  return all;
}

// Returns J: the energy if every particle moves a thousand float32 units in the last place in a step, of the largest distance
// from the first particle along an axis; ten thousand under constraints, whose chains round in each of their many sub-steps.
template <class T>
double noise_of(const SceneFile& file, const State<T>& state, const Held& held) {
  struct Sums {
    double mass = 0, largest = 0;
    std::array<double, 3> first{};  // where the first particle is
    bool has_first = false;
  };
  const Sums all = in_turn(held.ranks, Sums{}, [&](Sums sums) {
    for (std::size_t k = 0; k < state.count; ++k) {
      if (!sums.has_first) {
        for (std::size_t axis = 0; axis < 3; ++axis) sums.first[axis] = static_cast<double>(state.x[axis][k]);
        sums.has_first = true;
      }
      sums.mass += file.scene.mass[held.first + k];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        // Subtracted in T, as all numbers of a state are.
        const T way = state.x[axis][k] - static_cast<T>(sums.first[axis]);
        sums.largest = std::max(sums.largest, std::abs(static_cast<double>(way)));
      }
    }
    return sums;
  });
  const double units = file.scene.constraints.empty() ? 1e3 : 1e4;
  const double speed = units * static_cast<double>(std::numeric_limits<float>::epsilon()) * all.largest / file.step;
  return 0.5 * all.mass * speed * speed;
}

bool pushes_out(const Scene& scene) {
  return std::any_of(scene.contacts.begin(), scene.contacts.end(), [](const Contact& contact) {
    return std::visit([](const auto& c) { return c.push_out.has_value(); }, contact);
  });
}

// Whether pairs that are too near at the start are pushed apart: they keep the speed at which they go.
bool puts_apart(const Scene& scene) {
  if (!scene.meet || scene.meet->near_at_start == NearAtStart::pass) return false;
  return scene.meet->near_at_start == NearAtStart::meet || scene.meet->radius.has_value();
}

}  // namespace

template <class T>
EnergyBudget::EnergyBudget(const SceneFile& file, const State<T>& start, const Held& held)
    : file_(file),
      held_(held),
      air_(file.scene, file.particles.count, held),
      account_{.now = moments_of(file.scene, start, held, air_.at(start)), .seconds = start.clock.seconds},
      start_mass_(account_.now.mass),
      noise_(noise_of(file, start, held)) {
  // energy() is kinetic energy, that of springs, and -a.mx of the constant forces, which is taken out again.
  start_ = energy(file, start, held);
  for (const auto& force : file.scene.forces) {
    const auto* constant = std::get_if<Constant>(&force);
    if (constant == nullptr) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) start_ += constant->acceleration[axis] * account_.now.mass[axis];
  }
}

template <class T>
void EnergyBudget::look(const State<T>& state) {
  auto& [now, seconds, work, most_work] = account_;
  const auto next = moments_of(file_.scene, state, held_, air_.at(state));
  const double until = state.clock.seconds;
  const double sixth = (until - seconds) / 6;
  const Vec3 a0 = acceleration_at(file_.scene, seconds);
  const Vec3 a = acceleration_at(file_.scene, 0.5 * (seconds + until));
  const Vec3 a1 = acceleration_at(file_.scene, until);
  // The displacement is h/6 (p0 + 4 p + p1), the work h/6 (a0 p0 + 4 a p + a1 p1).
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

double EnergyBudget::share_of(double joules) const noexcept {
  if (std::isnan(joules)) return joules;
  return joules <= noise_ ? 0 : joules / std::max(given(), noise_);
}

double EnergyBudget::driven() const noexcept {
  double driven = account_.work;
  for (const auto& force : file_.scene.forces) {
    const auto* constant = std::get_if<Constant>(&force);
    if (constant == nullptr) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      driven -= constant->acceleration[axis] * (account_.now.mass[axis] - start_mass_[axis]);
    }
  }
  return driven;
}

std::optional<std::uint64_t> steps_between_looks(const SceneFile& file) {
  constexpr double turn = 0.3;  // rad, between looks
  constexpr double coarse = 1;  // rad a step: beyond it the middle represents nothing
  if ((file.scene.networks.empty() && file.scene.constraints.empty()) || is_live(file) || !(file.step > 0)) return std::nullopt;
  if (has_followers(file.scene) || pushes_out(file.scene) || puts_apart(file.scene)) return std::nullopt;
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
  const double part = limit.frequency * step / limit.substeps / limit.limit;  // 0 if there is no limit
  return bar * std::min(most_swing, part < 1 ? 1 / (1 - part * part) : most_swing);
}

template EnergyBudget::EnergyBudget(const SceneFile&, const State<float>&, const Held&);
template EnergyBudget::EnergyBudget(const SceneFile&, const State<double>&, const Held&);
template void EnergyBudget::look(const State<float>&);
template void EnergyBudget::look(const State<double>&);

}  // namespace dvdx::tool
