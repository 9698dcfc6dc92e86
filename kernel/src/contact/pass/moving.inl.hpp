// Surfaces that move, wide: a path as they see it, and their velocity. The scalar twin: moving_reference.hpp.
#pragma once

#include <array>
#include <cstddef>

#include "contact/surfaces/surface.hpp"
#include "simd/lanes.hpp"
#include "simd/three.inl.hpp"
#include "simd/trajectory.inl.hpp"

namespace dvdx {
namespace {

template <class V, Arithmetic arithmetic>
Three<V> cross_product(const Three<V>& a, const Three<V>& b) noexcept {
  return {{subtract_product<arithmetic>(a[1] * b[2], a[2], b[1]), subtract_product<arithmetic>(a[2] * b[0], a[0], b[2]),
           subtract_product<arithmetic>(a[0] * b[1], a[1], b[0])}};
}

template <class V, Arithmetic arithmetic>
V by_powers(const std::array<Scalar<V>, 7>& terms, V x) noexcept {
  V sum(terms[6]);
  for (std::size_t n = 6; n-- > 0;) sum = multiply_add<arithmetic>(sum, x, V(terms[n]));
  return sum;
}

// Returns r turned by the rotation vector w.
template <class V, Arithmetic arithmetic>
Three<V> turned_by(const Three<V>& w, const Three<V>& r) noexcept {
  const V square = dot<arithmetic>(w, w);
  const V a = by_powers<V, arithmetic>(turn_sine<Scalar<V>>, square);
  const V b = by_powers<V, arithmetic>(turn_versine<Scalar<V>>, square);
  const Three<V> once = cross_product<V, arithmetic>(w, r);
  const Three<V> twice = cross_product<V, arithmetic>(w, once);
  return multiply_add<arithmetic>(b, twice, multiply_add<arithmetic>(a, once, r));
}

// Returns the vector from the point `at` of the axis to x, at the time t before the end.
template <class V, Arithmetic arithmetic>
Three<V> arm_of(const Surface<Scalar<V>>& surface, const Three<V>& x, V t) noexcept {
  return multiply_add<arithmetic>(t, three<V>(surface.u), x) - three<V>(surface.at);
}

// Returns the velocity of the surface at x, at the time t before the end.
template <class V, Arithmetic arithmetic>
Three<V> velocity_at(const Surface<Scalar<V>>& surface, const Three<V>& x, V t) noexcept {
  const Three<V> u = three<V>(surface.u);
  if (surface.movement != Movement::turns) return u;
  return u + cross_product<V, arithmetic>(three<V>(surface.omega), arm_of<V, arithmetic>(surface, x, t));
}

// Returns where a surface carries a point that is at x at the time t before the end.
template <class V, Arithmetic arithmetic>
Three<V> taken_along(const Surface<Scalar<V>>& surface, const Three<V>& x, V t) noexcept {
  if (surface.movement != Movement::turns) return multiply_add<arithmetic>(t, three<V>(surface.u), x);
  return three<V>(surface.at) + turned_by<V, arithmetic>(t * three<V>(surface.omega), arm_of<V, arithmetic>(surface, x, t));
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Trajectory<V> as_seen(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, V t) noexcept {
  Trajectory<V> seen = m;
  seen.x0 = taken_along<V, arithmetic>(surface, m.x0, t);
  seen.v0 = m.v0 - velocity_at<V, arithmetic>(surface, m.x0, t);
  if (surface.movement == Movement::turns) seen.v0 = turned_by<V, arithmetic>(t * three<V>(surface.omega), seen.v0);
  seen.v1 = m.v1 - velocity_at<V, arithmetic>(surface, m.x1, V(Scalar<V>(0)));
  return seen;
}

// Returns the trajectory as the surface sees it, stored in `room`, or the trajectory itself if the surface rests.
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline const Trajectory<V>& seen_from(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, V t,
                                                             Trajectory<V>& room) noexcept {
  if (surface.movement == Movement::rest) return m;
  room = as_seen<V, arithmetic>(surface, m, t);
  return room;
}

// l and q of a bent path (surface.hpp).
template <class V>
struct Slip {
  bool is_there;
  Three<V> l, q;
};

template <class V>
Slip<V> slip_of(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, const Trajectory<V>& seen, V t) noexcept {
  const Three<V> none = three<V>(V(Scalar<V>(0)));
  if (surface.movement == Movement::rest) return {false, none, none};
  const Three<V> l = t * (seen.v0 - m.v0);
  if (surface.movement != Movement::turns) return {true, l, none};
  return {true, l, ((seen.x1 - seen.x0) - (m.x1 - m.x0)) - l};
}

}  // namespace
}  // namespace dvdx
