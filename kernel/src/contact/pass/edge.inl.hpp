// Edges between two surfaces that springs press a particle onto, wide. The scalar twin: edge_reference.hpp.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

#include "contact/pass/respond.inl.hpp"

namespace dvdx {
namespace {

// One surface for each lane, as the lane sees it where they meet.
template <class V>
struct Wall {
  V s, mu, hold, radius, falls_away;
  Three<V> n, v;
};

template <class V, Arithmetic arithmetic, PathForm form>
[[gnu::noinline]] Wall<V> met_by(const Terms<Scalar<V>>& terms, const Three<V>& x,
                                 const ImpactState<V, arithmetic, form>& state, V number, Mask<V> lanes) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  Wall<V> met{zero, zero, zero, zero, zero, three<V>(zero), three<V>(zero)};
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const Mask<V> is_it = lanes & (number == V(static_cast<T>(j)));
    if (!any_lane<V>(is_it)) continue;
    const bool moves = surface.movement != Movement::rest;
    const Touch<V> at = touch<V, arithmetic>(surface, moves ? taken_along<V, arithmetic>(surface, x, state.t) : x);
    Meeting<V> meets{at.n, three<V>(zero)};
    if (moves) meets = meeting<V, arithmetic>(surface, x, state.t);
    met.s = select<V>(is_it, at.s, met.s);
    met.mu = select<V>(is_it, V(surface.mu), met.mu);
    met.hold = select<V>(is_it, V(surface.hold), met.hold);
    met.radius = select<V>(is_it, V(surface.radius), met.radius);
    met.falls_away = select<V>(is_it, V(surface.falls_away), met.falls_away);
    met.n = select(is_it, meets.n, met.n);
    met.v = select(is_it, meets.v, met.v);
  }
  return met;
}

// Lanes of a network were pressed onto a surface b and, after the part f of the remaining step, onto another surface a.
// Resolves both impacts together.
template <class V, Arithmetic arithmetic, PathForm form>
[[gnu::noinline]] void settle_in_edge(const Terms<Scalar<V>>& terms, const Pressed<V>& before, Pressed<V>& pressed, V f,
                                      Trajectory<V>& m, const ImpactState<V, arithmetic, form>& state, Mask<V> lanes) noexcept {
  using T = Scalar<V>;
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const V zero(T(0));
  const V one(T(1));
  lanes = lanes & (before.by >= zero) & (pressed.by >= zero) & differ(before.by, pressed.by);
  if (!any_lane<V>(lanes)) return;
  const Wall<V> b = met_by<V, arithmetic, form>(terms, m.x0, state, before.by, lanes);
  const V way = V(std::abs(terms.h)) * one_norm(before.v);
  const V sizes = ((one_norm(m.x0) + one_norm(m.x1)) + (b.radius + b.radius)) + way;
  const V near = V(8 * eps) * sizes + b.falls_away * (way * way);
  lanes = lanes & (b.s <= near);
  if (!any_lane<V>(lanes)) return;
  const Wall<V> a = met_by<V, arithmetic, form>(terms, m.x0, state, pressed.by, lanes);
  const Wedge<V> wedge = wedge_of<V, arithmetic>(a.n, b.n);
  const V kappa = wedge.kappa;
  const V scale = wedge.scale;
  const Mask<V> is_at_once = f <= V(16 * eps);
  const V flat = V(T(most_pulses)) * (one - kappa);
  const V reach = (before.removed + before.removed) * select<V>(flat < one, flat, one);
  lanes = lanes & wedge.is_wedge & (is_at_once | (!(kappa > zero)) | (pressed.removed <= reach));
  if (!any_lane<V>(lanes)) return;

  const Three<V> across = scale * subtract_product<arithmetic>(b.n, kappa, a.n);
  const V share = dot<arithmetic>(b.n, b.v - a.v);
  const Three<V> v = multiply_add<arithmetic>(share, across, a.v);
  const Three<V> u = select(is_at_once, before.v, m.v0) - v;
  const V ua = state.direction * dot<arithmetic>(a.n, u);
  const V ub = state.direction * dot<arithmetic>(b.n, u);
  const V both_a = scale * (kappa * ub - ua);
  const V both_b = scale * (kappa * ua - ub);
  const Mask<V> has_b = both_b >= zero;
  const Mask<V> is_one = is_at_once & !(has_b & (both_a >= zero));
  const V alone_a = select<V>(has_b, zero, select<V>(ua < zero, negative(ua), zero));
  const V alone_b = select<V>(has_b, select<V>(ub < zero, negative(ub), zero), zero);
  const V taken_a = select<V>(is_one, alone_a, both_a);
  const V taken_b = select<V>(is_one, alone_b, both_b);
  const Mask<V> is_edge = differ(taken_a, zero) & differ(taken_b, zero);
  const Three<V> by_a = multiply_add<arithmetic>(state.direction * taken_a, a.n, u);
  const Three<V> rough = multiply_add<arithmetic>(state.direction * taken_b, b.n, by_a);
  // In a flat edge both pulses are large against the velocity left. Friction would act on their rounding errors: solve again.
  const V left_a = dot<arithmetic>(a.n, rough);
  const V left_b = dot<arithmetic>(b.n, rough);
  const V more_a = select<V>(is_edge, scale * (kappa * left_b - left_a), zero);
  const V more_b = select<V>(is_edge, scale * (kappa * left_a - left_b), zero);
  const Three<V> along = multiply_add<arithmetic>(more_b, b.n, multiply_add<arithmetic>(more_a, a.n, rough));
  const V pressed_a = select<V>(taken_a > zero, taken_a, zero);
  const V pressed_b = select<V>(taken_b > zero, taken_b, zero);
  const V slide = multiply_add<arithmetic>(b.mu, pressed_b, a.mu * pressed_a);
  const V hold = multiply_add<arithmetic>(b.hold, pressed_b, a.hold * pressed_a);
  const V kept = kept_by_friction(slide, hold, square_root(dot<arithmetic>(along, along)));
  const V onto_a = select<V>(is_edge, scale * (kappa * b.s - a.s), zero);
  const V onto_b = select<V>(is_edge, scale * (kappa * a.s - b.s), zero);
  const Three<V> shift = multiply_add<arithmetic>(onto_b, b.n, onto_a * a.n);
  const Three<V> after = multiply_add<arithmetic>(kept, along, v);
  const Three<V> pulse = after - m.v0;
  Three<V> x1 = m.x1 + shift;
  Three<V> v1;
  if constexpr (form == PathForm::parabola) {
    x1 = multiply_add<arithmetic>(state.t, pulse, x1);
    v1 = after + (m.v1 - m.v0);
  } else {
    for (std::size_t k = 0; k < 3; ++k) {
      const V P0 = state.end.P0[k];
      x1[k] = multiply_add<arithmetic>(state.h * state.end.P1[k], pulse[k], x1[k]);
      v1[k] = multiply_add<arithmetic>(P0, after[k], subtract_product<arithmetic>(m.v1[k], P0, m.v0[k]));
    }
  }
  m.x0 = select(lanes, m.x0 + shift, m.x0);
  m.x1 = select(lanes, x1, m.x1);
  m.v1 = select(lanes, v1, m.v1);
  m.v0 = select(lanes, after, m.v0);
  pressed.v = select(lanes, after, pressed.v);
}

}  // namespace
}  // namespace dvdx
