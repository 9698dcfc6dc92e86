#include "closed_form/impacts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "closed_form/held.hpp"
#include "closed_form/motion.hpp"
#include "closed_form/surface.hpp"

namespace dvdx::tool {
namespace impacts {
namespace {

constexpr std::uint64_t most_impacts = 200000;
constexpr std::uint64_t most_phases = 1000000;

struct Point {
  Vector x;  // m
  Vector v;  // m/s
};

// The path of one particle, from event to event.
class Journey {
 public:
  Journey(std::vector<Surface> surfaces, const Field& field, const Point& start, std::span<const Real> times, Real caution)
      : surfaces_(std::move(surfaces)),
        field_(field),
        times_(times),
        duration_(times.back()),
        caution_(caution),
        x_(start.x),
        v_(start.v),
        gaps_(surfaces_.size()),
        touches_(surfaces_.size()) {
    for (std::size_t j = 0; j < surfaces_.size(); ++j) {
      gaps_[j] = surfaces_[j].gap(x_);
      // The start has the precision of a double only.
      if (gaps_[j] < -1e-15L * (1 + length(x_))) throw NotCovered("starts inside a surface");
      gaps_[j] = std::max(gaps_[j], 0.0L);
    }
    points_.reserve(times.size());
  }

  void run() {
    for (std::uint64_t phase = 0; points_.size() < times_.size(); ++phase) {
      if (phase == most_phases) throw NotCovered("changes its motion more than a million times");
      find_touches();
      resolve_impacts();
      const auto held = hold(surfaces_, still_touching(), field_, x_, v_);
      if (held.is_stuck) return rest();
      follow(held);
    }
  }

  [[nodiscard]] const std::vector<Point>& points() const { return points_; }
  [[nodiscard]] std::uint64_t impacts() const { return impacts_; }

 private:
  void find_touches() {
    for (std::size_t j = 0; j < surfaces_.size(); ++j) {
      constexpr Real nothing = 0x1p-60L;
      if (gaps_[j] <= nothing * (1 + length(x_))) {
        // The surface hit last may be left by any distance, however small.
        touches_[j] = gaps_[j] <= 0 || j != last_;
        if (touches_[j]) gaps_[j] = 0;
      } else {
        touches_[j] = false;
      }
    }
  }

  [[nodiscard]] Real normal_speed(std::size_t j) const { return dot(surfaces_[j].normal_at(x_), v_); }

  // The speed below which only rounding separates a velocity from a tangential one.
  [[nodiscard]] Real rounded_speed() const { return 0x1p-58L * (length(v_) + 0x1p-30L * duration_ * length(field_.at(v_))); }

  void resolve_impacts() {
    const Real none = rounded_speed();
    constexpr int most_at_once = 1000;
    for (int i = 0; i < most_at_once; ++i) {
      std::size_t j = 0;
      while (j < surfaces_.size() && !(touches_[j] && normal_speed(j) < -none)) ++j;
      if (j == surfaces_.size()) {
        for (const auto at : still_touching()) v_ -= normal_speed(at) * surfaces_[at].normal_at(x_);
        if (length(v_) <= 0x1p-88L * duration_ * length(field_.at(v_))) v_ = {};
        return;
      }
      strike(j);
    }
    throw NotCovered("is caught between surfaces");
  }

  [[nodiscard]] std::vector<std::size_t> still_touching() const {
    const Real none = rounded_speed();
    std::vector<std::size_t> all;
    for (std::size_t j = 0; j < surfaces_.size(); ++j) {
      if (touches_[j] && std::abs(normal_speed(j)) <= none) all.push_back(j);
    }
    return all;
  }

  void strike(std::size_t j) {
    const auto& surface = surfaces_[j];
    const Vector n = surface.normal_at(x_);
    v_ = after_impact(surface, n, v_);
    last_ = j;
    if (++impacts_ == most_impacts) throw NotCovered(fmt::format("has more than {} impacts", most_impacts));
    const Real up = dot(n, v_);
    if (surface.e < 1 && up > 0) settle(j, n, up);
    if (surface.e == 0) v_ -= dot(n, v_) * n;
  }

  // Closes the train of impacts that follows this one if the train ends almost at once.
  void settle(std::size_t j, const Vector& n, Real up) {
    auto others = still_touching();
    std::erase(others, j);
    const auto held = hold(surfaces_, others, field_, x_, v_);
    const Real towards = -(dot(n, held.acceleration(v_)) + surfaces_[j].curvature_term(v_ - up * n));
    const Real left = 2 * up / (towards * (1 - surfaces_[j].e));
    if (towards <= 0 || left > 0x1p-50L * duration_) return;
    v_ -= up * n;
    const Real speed = length(v_);
    if (surfaces_[j].tau < 1) {
      v_ = {};
    } else if (speed > 0 && std::isfinite(surfaces_[j].mu)) {
      // The slide that replaces the train subtracts friction mu N for the train's whole duration. The train's normal pulses sum
      // to less by the outward speed, so this returns mu times that speed.
      v_ *= 1 + surfaces_[j].mu * up / speed;
    }
  }

  void follow(const Held& held) {
    const Real left = std::max(duration_ - time_, 0.0L);
    if (held.is_bent) {
      const SlideStep slide({held.normal, held.force, field_.g, held.friction}, v_, caution_);
      const Real end = slide.time(slide.end()) < left ? slide.end() : slide.parameter_at(left);
      move(slide, held, end, left);
      if (held.friction > length(held.force) && length(v_) < 0x1p-58L * duration_ * (held.friction - length(held.force))) {
        v_ = {};
      }
      return;
    }
    const bool stops = held.stop < left;
    move(held.motion, held, stops ? held.stop : left, left);
    if (stops && hit_ == surfaces_.size()) v_ = {};
  }

  // Follows a motion to its end or to its first impact.
  template <class Motion>
  void move(const Motion& motion, const Held& held, Real end, Real left) {
    Real until = end;
    hit_ = surfaces_.size();
    for (std::size_t j = 0; j < surfaces_.size(); ++j) {
      if (held.holds(j)) continue;
      const auto at = first_impact(motion, surfaces_[j], x_, gaps_[j], until);
      if (!at) continue;
      until = *at;
      hit_ = j;
    }
    const bool is_last = hit_ == surfaces_.size() && motion.time(end) >= left * (1 - 0x1p-60L);
    const Real passed = motion.time(until);
    while (points_.size() < times_.size() && (is_last || times_[points_.size()] <= time_ + passed)) {
      const Real p = std::min(motion.parameter_at(std::max(times_[points_.size()] - time_, 0.0L)), until);
      points_.push_back({x_ + motion.displacement(p), motion.velocity(p)});
    }
    const Vector way = motion.displacement(until);
    for (std::size_t j = 0; j < surfaces_.size(); ++j) {
      gaps_[j] = j == hit_ || held.holds(j) ? 0 : std::max(gaps_[j] + surfaces_[j].gain(x_, way), 0.0L);
    }
    x_ += way;
    v_ = motion.velocity(until);
    time_ += passed;
    if (hit_ < surfaces_.size()) last_ = hit_;
  }

  void rest() {
    while (points_.size() < times_.size()) points_.push_back({x_, {}});
  }

  std::vector<Surface> surfaces_;
  Field field_;
  std::span<const Real> times_;
  Real duration_;
  Real caution_;
  Real time_ = 0;
  Vector x_;
  Vector v_;
  std::vector<Real> gaps_;
  std::vector<bool> touches_;
  std::size_t hit_ = 0;
  std::size_t last_ = static_cast<std::size_t>(-1);
  std::uint64_t impacts_ = 0;
  std::vector<Point> points_;
};

Field field_of(const SceneFile& file, std::size_t particle) {
  Field field;
  const Real mass = file.scene.mass[particle];
  for (const auto& force : file.scene.forces) {
    if (const auto* constant = std::get_if<Constant>(&force)) {
      field.b += vector_of(constant->acceleration);
    } else if (const auto* drag = std::get_if<Drag>(&force)) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const Real g = drag->coefficient.at(axis, particle) / mass;
        field.g[axis] += g;
        field.b[axis] += g * drag->wind[axis];
      }
    } else {
      throw NotCovered("other forces than constant ones and drag act");
    }
  }
  return field;
}

Vector origin_of(PathOrigin counted_from) {
  return counted_from == PathOrigin::world ? Vector{}
                                           : Vector{{0.7071067811865475244L, -1.2599210498948731648L, 0.5772156649015328606L}};
}

}  // namespace
}  // namespace impacts

std::variant<ImpactPath, NoImpactPath> impact_path(const SceneFile& file, double unit, std::span<const std::uint64_t> counts,
                                                   PathOrigin counted_from) {
  using namespace impacts;
  if (is_joined(file.scene)) return NoImpactPath{"particles are joined"};
  ImpactPath result{.path = Path(file.particles.count, counts.size())};
  std::vector<Real> times;
  for (const auto count : counts) times.push_back(static_cast<Real>(unit) * static_cast<Real>(count));
  const Vector origin = origin_of(counted_from);
  std::vector<Surface> surfaces;
  try {
    for (const auto& contact : file.scene.contacts) surfaces.push_back(surface_of(contact, origin));
  } catch (const NotCovered& reason) {
    return NoImpactPath{fmt::format("a particle {}", reason.what())};
  }
  auto fixed = file.scene.fixed;
  std::sort(fixed.begin(), fixed.end());
  for (std::size_t i = 0; i < file.particles.count; ++i) {
    const Point start{vector_of(value_of(file.particles.position, i)) - origin,
                      vector_of(value_of(file.particles.velocity, i))};
    const bool is_fixed = std::binary_search(fixed.begin(), fixed.end(), i);
    try {
      Journey journey(is_fixed ? std::vector<Surface>{} : surfaces, field_of(file, i), start, times,
                      counted_from == PathOrigin::world ? 6 : 8);
      if (!is_fixed) journey.run();
      result.most_impacts = std::max(result.most_impacts, journey.impacts());
      for (std::size_t k = 0; k < counts.size(); ++k) {
        const Point point = is_fixed ? Point{start.x, {}} : journey.points()[k];
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const auto at = result.path.index(k, i, axis);
          result.path.x[at] = point.x[axis] + origin[axis];
          result.path.v[at] = point.v[axis];
        }
      }
    } catch (const NotCovered& reason) {
      return NoImpactPath{fmt::format("particle {} {}", i, reason.what())};
    }
  }
  return result;
}

}  // namespace dvdx::tool
