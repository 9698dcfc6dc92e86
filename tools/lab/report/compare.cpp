#include "report/compare.hpp"

#include <algorithm>
#include <cmath>

#include "watch/energy.hpp"

namespace dvdx::tool::report {

template <class T>
void Comparison::take(const State<T>& state, std::size_t time) {
  take(state, time, tool::energy(sample_, state));
}

template <class T>
void Comparison::take(const State<T>& state, std::size_t time, double energy) {
  const auto& path = reference_.path;
  const bool is_within = time < reference_.horizon;
  std::size_t bad = 0;
  for (std::size_t i = 0; i < path.particles; ++i) {
    long double position = 0;
    long double velocity = 0;
    const auto particle = reference_.picks[i];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto at = path.index(time, i, axis);
      const auto dx = static_cast<long double>(state.x[axis][particle]) - path.x[at];
      const auto dv = static_cast<long double>(state.v[axis][particle]) - path.v[at];
      position += dx * dx;
      velocity += dv * dv;
    }
    if (!std::isfinite(position) || !std::isfinite(velocity)) ++bad;
    if (time == 0) continue;  // the start is given: it counts for the energy only
    all_squares_ += static_cast<double>(position);
    ++all_compared_;
    if (!is_within) continue;
    position_squares_ += static_cast<double>(position);
    velocity_squares_ += static_cast<double>(velocity);
    largest_square_ = std::max(largest_square_, static_cast<double>(position));
    ++compared_;
  }
  bad_particles_ = std::max(bad_particles_, bad);
  energy_.push_back(energy);
  if (!is_within && !reference_.keeps_energy) return;
  const double expected = reference_.keeps_energy ? energy_.front() : reference_.energy[time];
  drift_ = std::max(drift_, std::abs(energy_.back() - expected));
}

Errors Comparison::errors() const {
  const auto count = static_cast<double>(compared_);
  Errors errors{.position_rms = std::sqrt(position_squares_ / count),
                .position_max = std::sqrt(largest_square_),
                .velocity_rms = std::sqrt(velocity_squares_ / count),
                .relative = 0,
                .energy_drift = drift_ / reference_.energy_scale,
                .diverged = bad_particles_ > 0,
                .bad_particles = bad_particles_};
  errors.relative = errors.position_rms / reference_.amplitude;
  const double from_all = std::sqrt(all_squares_ / static_cast<double>(all_compared_));
  errors.diverged =
      errors.diverged || !(from_all <= diverged_beyond * reference_.whole_amplitude) || !std::isfinite(errors.velocity_rms);
  if (reference_.whole_amplitude == 0) errors.diverged = bad_particles_ > 0;  // nothing moves: there is no scale for divergence
  return errors;
}

template void Comparison::take(const State<float>&, std::size_t);
template void Comparison::take(const State<double>&, std::size_t);
template void Comparison::take(const State<double>&, std::size_t, double);

}  // namespace dvdx::tool::report
