// Leads lanes out of surfaces inside which they start, wide. The scalar twin: push_out_reference.hpp.
#pragma once

#include <cstddef>
#include <limits>

#include "contact/pass/rest.inl.hpp"

namespace dvdx {
namespace {

// The start of paths as the surface sees it. is_inside: deeper than rounding; is_free: further out than rounding.
template <class V>
struct Start {
  Touch<V> at;
  Mask<V> is_inside, is_free;
};

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Start<V> start_on(const Surface<Scalar<V>>& surface, const Three<V>& x, V t) noexcept {
  using T = Scalar<V>;
  const Three<V> there = surface.movement == Movement::rest ? x : taken_along<V, arithmetic>(surface, x, t);
  const Touch<V> at = touch<V, arithmetic>(surface, there);
  const V rounding = V(least_depth * std::numeric_limits<T>::epsilon()) * (one_norm(there) + V(surface.radius));
  return {at, (at.s < negative(rounding)), (at.s > rounding)};
}

template <class V, Arithmetic arithmetic, PathForm form>
Mask<V> leaves(const Surface<Scalar<V>>& surface, const ImpactState<V, arithmetic, form>& state) noexcept {
  if (state.leaving == nullptr || !pushes_out(surface)) return Mask<V>(false);
  const Leaving<V>& leaving = *state.leaving;
  return leaving.lanes & start_on<V, arithmetic>(surface, leaving.x0, leaving.t).is_inside;
}

template <class V>
V within(V x, V least, V most) noexcept {
  return select<V>(x < least, least, select<V>(x > most, most, x));
}

template <class V, Arithmetic arithmetic, PathForm form>
[[gnu::noinline]] void leave(const Surface<Scalar<V>>& surface, Trajectory<V>& m, const ImpactState<V, arithmetic, form>& state,
                             Mask<V> lanes) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V speed(surface.push_out);
  const bool moves = surface.movement != Movement::rest;
  Trajectory<V> room;
  const Trajectory<V>& seen = seen_from<V, arithmetic>(surface, m, state.t, room);
  const Touch<V> start = touch<V, arithmetic>(surface, seen.x0);
  const V way = state.t * speed;
  const V most = start.s + way;
  const Mask<V> stays_inside = most < zero;
  const V least = select<V>(stays_inside, most, zero);

  const V vn0 = dot<arithmetic>(start.n, seen.v0);
  const V slower = within<V>(vn0, zero, speed) - vn0;
  const bool turns = surface.movement == Movement::turns;
  const Three<V> n0 = turns ? turned_by<V, arithmetic>(negative(state.t) * three<V>(surface.omega), start.n) : start.n;
  const V gone = dot<arithmetic>(start.n, m.x1 - seen.x0);
  const V further = within<V>(gone, select<V>(stays_inside, way, negative(start.s)), way) - gone;
  const Three<V> v0 = multiply_add<arithmetic>(slower, n0, m.v0);
  const Three<V> x1 = multiply_add<arithmetic>(further, start.n, m.x1);

  const Touch<V> end = touch<V, arithmetic>(surface, x1);
  const V onto = within<V>(end.s, least, most) - end.s;
  const Three<V> v = moves ? velocity_at<V, arithmetic>(surface, x1, zero) : three<V>(zero);
  const Three<V> held = multiply_add<arithmetic>(slower, n0, m.v1);
  const Three<V> u = moves ? held - v : held;
  const V vn = dot<arithmetic>(end.n, u);
  const V out = within<V>(vn, zero, speed);
  const V removed = select<V>(slower > zero, slower, zero) + select<V>(vn < zero, negative(vn), zero);
  const Three<V> vt = subtract_product<arithmetic>(u, vn, end.n);
  const V kept = kept_by_friction(V(surface.mu) * removed, V(surface.hold) * removed, square_root(dot<arithmetic>(vt, vt)));
  const Three<V> v1 = multiply_add<arithmetic>(out, end.n, kept * vt);
  m.v0 = select(lanes, v0, m.v0);
  m.v1 = select(lanes, moves ? v1 + v : v1, m.v1);
  m.x1 = select(lanes, multiply_add<arithmetic>(onto, end.n, x1), m.x1);
}

// Whether two surfaces face each other, so that friction jams a particle between them. kappa: the product of their normals.
template <class V>
Mask<V> face_each_other(V mu_a, V mu_b, V kappa) noexcept {
  using T = Scalar<V>;
  const V one(T(1));
  const V least(least_grip<T>);
  const V mu = select<V>(mu_a < mu_b, mu_a, mu_b);
  const V grip = select<V>(mu > least, mu, least);
  const V opening = one - kappa;
  return one + kappa <= grip * grip * opening;
}

// Returns the lanes that start inside a surface that pushes out, and not between two surfaces that face each other.
template <class V, Arithmetic arithmetic, PathForm form>
Mask<V> starting_to_leave(const Terms<Scalar<V>>& terms, const Trajectory<V>& m, const ImpactState<V, arithmetic, form>& state,
                          Mask<V> lanes) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  V deepest(T(-1));
  V mu = zero;
  Touch<V> a{three<V>(zero), zero};
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    if (!pushes_out(surface)) continue;
    const Start<V> start = start_on<V, arithmetic>(surface, m.x0, state.t);
    const Mask<V> is_it = lanes & start.is_inside & (start.at.s < a.s);
    deepest = select<V>(is_it, V(static_cast<T>(j)), deepest);
    mu = select<V>(is_it, V(surface.mu), mu);
    a = {select(is_it, start.at.n, a.n), select<V>(is_it, start.at.s, a.s)};
  }
  lanes = lanes & (deepest >= zero);
  if (!any_lane<V>(lanes)) return lanes;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const Start<V> start = start_on<V, arithmetic>(surface, m.x0, state.t);
    const Mask<V> is_other = (!start.is_free) & differ(deepest, V(static_cast<T>(j)));
    lanes = lanes & !(is_other & face_each_other<V>(mu, V(surface.mu), dot<arithmetic>(a.n, start.at.n)));
  }
  return lanes;
}

// Brings lanes out of the surfaces that they leave, each along its own normal.
template <class V, Arithmetic arithmetic, PathForm form>
[[gnu::noinline]] void push_out(const Terms<Scalar<V>>& terms, Trajectory<V>& m, ImpactState<V, arithmetic, form>& state,
                                Mask<V> lanes, Leaving<V>& leaving) noexcept {
  lanes = starting_to_leave<V, arithmetic, form>(terms, m, state, lanes);
  if (!any_lane<V>(lanes)) return;
  leaving = {m.x0, state.t, lanes};
  state.leaving = &leaving;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Mask<V> leaving_it = leaves<V, arithmetic, form>(terms.surfaces[j], state);
    if (any_lane<V>(leaving_it)) leave<V, arithmetic, form>(terms.surfaces[j], m, state, leaving_it);
  }
}

}  // namespace
}  // namespace dvdx
