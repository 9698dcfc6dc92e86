// Surfaces, the impact law of docs/math.md, and the search for the next impact.
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include "closed_form/vector.hpp"
#include "dvdx/scene.hpp"

namespace dvdx::tool::impacts {

// Thrown for a motion that the event-driven path does not cover, with the reason.
class NotCovered : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Surface {
  bool is_plane = true;
  Vector n;         // plane: unit normal
  Real d = 0;       // plane: particles are where n.x >= d
  Vector center;    // sphere
  Real radius = 1;  // sphere
  Real side = 1;    // sphere: 1 if particles are outside, -1 inside
  Real e = 0;       // the part of the normal speed that an impact leaves
  Real tau = 1;     // the part of the tangential velocity that it leaves, before friction
  Real mu = 0;      // Coulomb's coefficient; infinite: a particle that touches sticks

  [[nodiscard]] Vector normal_at(const Vector& x) const { return is_plane ? n : (side / radius) * (x - center); }

  // Zero on the surface, positive on the particles' side: the distance from a plane, side (|r|^2 - R^2)/(2R) of a sphere.
  [[nodiscard]] Real gap(const Vector& x) const {
    if (is_plane) return dot(n, x) - d;
    const Vector r = x - center;
    return side * (length(r) - radius) * (length(r) + radius) / (2 * radius);
  }
  // Returns the change of the gap over a displacement, without cancellation of the digits that both ends share.
  [[nodiscard]] Real gain(const Vector& x, const Vector& way) const {
    if (is_plane) return dot(n, way);
    return side * (dot(x - center, way) + dot(way, way) / 2) / radius;
  }
  [[nodiscard]] Real slope(const Vector& x, const Vector& way, const Vector& rate) const {
    return is_plane ? dot(n, rate) : side * dot(x + way - center, rate) / radius;
  }
  // A tangential velocity accelerates the gap of a sphere by this much.
  [[nodiscard]] Real curvature_term(const Vector& v) const { return is_plane ? 0 : side * dot(v, v) / radius; }
};

// The surface of a contact, counted from `origin`.
[[nodiscard]] Surface surface_of(const Contact& contact, const Vector& origin);

// The velocity after an impact with the normal n, n.v <= 0.
[[nodiscard]] inline Vector after_impact(const Surface& surface, const Vector& n, const Vector& v) {
  const Real vn = dot(n, v);
  const Vector across = surface.tau * (v - vn * n);
  const Real speed = length(across);
  const Real pulse = vn < 0 ? surface.mu * (1 + surface.e) * -vn : 0;
  const Real kept = pulse >= speed ? 0 : 1 - pulse / speed;
  return kept * across - surface.e * vn * n;
}

// The parabola gap + slope h - fall h^2/2 is a lower bound of the gap from p to `until`. A step to its first zero cannot pass a
// zero of the gap, so no dip is missed. Near a zero the step is Newton's.
inline Real safe_reach(Real gap, Real slope, Real fall) {
  if (fall <= 0) return slope < 0 ? gap / -slope : std::numeric_limits<Real>::infinity();
  const Real root = std::sqrt(slope * slope + 2 * fall * gap);
  return slope < 0 ? 2 * gap / (root - slope) : (slope + root) / fall;
}

// The parameter of the first impact of a motion that starts at x with the given gap, if there is one before `end`.
template <class Motion>
std::optional<Real> first_impact(const Motion& motion, const Surface& surface, const Vector& x, Real start_gap, Real end) {
  const auto fall_until = [&](Real p, const Vector& way, Real until) -> Real {
    if (surface.is_plane) return motion.fall(surface.n, p, until);
    const Real rate = motion.greatest_rate(p, until);
    const Real reach = length(x + way - surface.center) + (until - p) * rate;
    const Real turning = surface.side < 0 ? rate * rate : 0;
    return (turning + reach * motion.greatest_second(p, until)) / surface.radius;
  };
  constexpr int most_steps = 2000;
  Real p = 0;
  for (int step = 0; step < most_steps; ++step) {
    const Vector way = motion.displacement(p);
    const Real gap = start_gap + surface.gain(x, way);
    const Real slope = surface.slope(x, way, motion.rate(p));
    if (p > 0 && gap <= 0) return p;
    Real until = end;
    Real h = std::min(safe_reach(gap, slope, fall_until(p, way, until)), until - p);
    for (int tighter = 0; tighter < 4 && h < (until - p) / 8; ++tighter) {  // the bound is tighter over a shorter span
      until = p + 8 * h;
      h = std::max(h, std::min(safe_reach(gap, slope, fall_until(p, way, until)), until - p));
    }
    if (h == 0 && p == 0) h = 1e-9L * end;  // the particle only just lifts off
    if (p + h >= end) return std::nullopt;
    if (h <= 2 * std::numeric_limits<Real>::epsilon() * p) return p;
    p += h;
  }
  throw NotCovered("touches a surface without an impact that can be told from none");
}

}  // namespace dvdx::tool::impacts
