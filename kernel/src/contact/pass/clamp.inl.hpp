// Puts particles whose step ends inside a surface onto it, or between two surfaces that leave no room, wide. The scalar twin:
// clamp_reference.hpp.
#pragma once

#include <cstddef>
#include <limits>

#include "contact/pass/push_out.inl.hpp"
#include "contact/pass/rest.inl.hpp"
#include "contact/pass/time_of_impact.inl.hpp"

namespace dvdx {
namespace {

template <class V, Arithmetic arithmetic, PathForm form>
void clamp(const Surface<Scalar<V>>& surface, Trajectory<V>& m, const ImpactState<V, arithmetic, form>& state, Mask<V> held,
           Mask<V> inside, V size) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const Three<V> n = touch<V, arithmetic>(surface, m.x1).n;
  Trajectory<V> room;
  const Trajectory<V>& seen = seen_from<V, arithmetic>(surface, m, state.t, room);
  const V vn = dot<arithmetic>(n, seen.v1);
  const V removed = magnitude(vn);
  const Three<V> vt = subtract_product<arithmetic>(seen.v1, vn, n);
  const V length = square_root(dot<arithmetic>(vt, vt));
  const V kept = kept_by_friction(V(surface.mu) * removed, V(surface.hold) * removed, length);
  const Mask<V> is_pressed = inside & (state.direction * vn < zero);
  const Three<V> slower = select(is_pressed, kept * vt, seen.v1);
  const V motion = magnitude(state.t) * one_norm(seen.v0 + slower);
  Mask<V> rests = held & (motion < V(std::numeric_limits<T>::epsilon() / 4) * size);
  if (state.leaving != nullptr) rests = rests & !state.leaving->lanes;
  const Three<V> base = select(rests, seen.x0, m.x1);
  const Touch<V> there = touch<V, arithmetic>(surface, base);
  m.x1 = select(inside, subtract_product<arithmetic>(base, there.s, there.n), m.x1);
  if (surface.movement == Movement::rest) {
    m.v1 = slower;
  } else {
    m.v1 = select(is_pressed, slower + velocity_at<V, arithmetic>(surface, m.x1, V(T(0))), m.v1);
  }
}

// Lanes on `a` are inside `b`. If the surfaces face each other and leave the lanes no room at the start either, moves them to
// the middle, with friction. Returns the lanes it moved.
template <class V, Arithmetic arithmetic, PathForm form>
[[gnu::noinline]] Mask<V> pinch(const Surface<Scalar<V>>& a, const Surface<Scalar<V>>& b, Trajectory<V>& m,
                                const ImpactState<V, arithmetic, form>& state, Mask<V> lanes) noexcept {
  using T = Scalar<V>;
  const V half_of(T(0.5));
  const Touch<V> end_a = touch<V, arithmetic>(a, m.x1);
  const Touch<V> end_b = touch<V, arithmetic>(b, m.x1);
  const V kappa = dot<arithmetic>(end_a.n, end_b.n);
  const V opening = V(T(1)) - kappa;
  lanes = lanes & face_each_other<V>(V(a.mu), V(b.mu), kappa);
  if (!any_lane<V>(lanes)) return lanes;
  Trajectory<V> room_a, room_b;
  const Trajectory<V>& from_a = seen_from<V, arithmetic>(a, m, state.t, room_a);
  const Trajectory<V>& from_b = seen_from<V, arithmetic>(b, m, state.t, room_b);
  const V sizes = (one_norm(m.x0) + one_norm(m.x1)) + V(a.radius + b.radius);
  const V room = touch<V, arithmetic>(a, from_a.x0).s + touch<V, arithmetic>(b, from_b.x0).s;
  lanes = lanes & (room < negative(V(8 * std::numeric_limits<T>::epsilon()) * sizes));
  if (!any_lane<V>(lanes)) return lanes;

  const V half = half_of * inverse(opening);
  const Three<V> axis = end_a.n - end_b.n;
  Three<V> v = half_of * ((m.v1 - from_a.v1) + (m.v1 - from_b.v1));
  Three<V> x = half_of * (from_a.x0 + from_b.x0);
  if (!(a.mu + b.mu > 0)) {
    const Three<V> u = m.v1 - v;
    v = v + subtract_product<arithmetic>(u, half * dot<arithmetic>(axis, u), axis);
    x = m.x1;
  }
  const V shift = half * (touch<V, arithmetic>(b, x).s - touch<V, arithmetic>(a, x).s);
  m.x1 = select(lanes, multiply_add<arithmetic>(shift, axis, x), m.x1);
  m.v1 = select(lanes, v, m.v1);
  return lanes;
}

// Pinches lanes inside `b` that were put onto another surface, `before`. Returns the lanes it moved.
template <class V, Arithmetic arithmetic, PathForm form>
[[gnu::noinline]] Mask<V> pinch_any(const Terms<Scalar<V>>& terms, const Surface<Scalar<V>>& b, V before, Trajectory<V>& m,
                                    const ImpactState<V, arithmetic, form>& state, Mask<V> lanes) noexcept {
  Mask<V> pinched(false);
  for (std::size_t i = 0; i < terms.surface_count; ++i) {
    const Mask<V> is_it = lanes & (before == V(static_cast<Scalar<V>>(i)));
    if (any_lane<V>(is_it)) pinched = pinched | pinch<V, arithmetic, form>(terms.surfaces[i], b, m, state, is_it);
  }
  return pinched;
}

template <class V, Arithmetic arithmetic, PathForm form>
void clamp_all(const Terms<Scalar<V>>& terms, Trajectory<V>& m, ImpactState<V, arithmetic, form>& state,
               Mask<V> touches) noexcept {
  using T = Scalar<V>;
  watch(terms, state, m.x1, touches);
  V tolerance(T(0));
  V before(T(-1));
  for (int round = 0; round < clamp_rounds; ++round) {
    Mask<V> is_clamped(false);
    for (std::size_t j = 0; j < terms.surface_count; ++j) {
      const auto& surface = terms.surfaces[j];
      const V size = one_norm(m.x1);
      const V number(static_cast<T>(j));
      const Mask<V> is_held = is_among(state.supports, number);
      // A lane that a plane holds already lies on that plane.
      const Mask<V> is_looked_at = round == 0 && surface.shape == Shape::plane ? touches & !is_held : touches;
      Mask<V> inside = is_looked_at & (touch<V, arithmetic>(surface, m.x1).s < -(tolerance * size));
      if (!any_lane<V>(inside)) continue;
      inside = inside & !leaves<V, arithmetic, form>(surface, state);
      const Mask<V> on_other = inside & (before >= V(T(0))) & differ(before, number);
      if (any_lane<V>(on_other)) {
        const Mask<V> pinched = pinch_any<V, arithmetic, form>(terms, surface, before, m, state, on_other);
        watch(terms, state, m.x1, pinched);
        inside = inside & !pinched;
        touches = touches & !pinched;
      }
      before = select<V>(inside, number, before);
      is_clamped = is_clamped | inside;
      clamp<V, arithmetic, form>(surface, m, state, (state.last == number) | is_held, inside, size);
      watch(terms, state, m.x1, inside);
    }
    touches = touches & is_clamped;
    if (!any_lane<V>(touches)) return;
    tolerance = V(2 * std::numeric_limits<T>::epsilon());
  }
}

}  // namespace
}  // namespace dvdx
