// The response to an impact, wide: restitution, friction, viscosity. The scalar twin: respond_reference.hpp.
#pragma once

#include <cstddef>
#include <limits>

#include "contact/pass/push_out.inl.hpp"
#include "contact/pass/rest.inl.hpp"
#include "contact/pass/time_of_impact.inl.hpp"
#include "contact/pass/touch_test.inl.hpp"

namespace dvdx {
namespace {

// Returns how far off a curved surface the springs of a network may have left lanes that lie on it.
template <class V, Arithmetic arithmetic>
V fallen_away(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, V t) noexcept {
  return V(surface.falls_away) * (t * t * dot<arithmetic>(m.v0, m.v0));
}

// Whether lanes of a network are as low over a surface, and come as slowly, as lanes that rest there between pulses.
template <class V>
Mask<V> hovers(const Surface<Scalar<V>>& surface, V s, V out, V press, V t) noexcept {
  const V flows(surface.flows_per_substep);
  const V fall = flows * press;
  return Mask<V>(has_pulses(surface)) & (s <= V(Scalar<V>(0.5)) * flows * fall * magnitude(t)) & (-out <= fall);
}

// Returns the part of the tangential velocity that an impact leaves: 0 if its bounces end within the step, 1 for lanes that
// already lay or slid on the surface.
template <class V, Arithmetic arithmetic, PathForm form>
V kept_by_viscosity(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, const ImpactState<V, arithmetic, form>& state,
                    const Three<V>& gain, Mask<V> is_over) noexcept {
  using T = Scalar<V>;
  const V one(T(1));
  if (surface.tau == 1) return one;
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const Touch<V> start = touch<V, arithmetic>(surface, m.x0);
  const V low = V(low_bounce * eps) * (one_norm(m.x0) + V(surface.radius));
  const V out = state.direction * dot<arithmetic>(start.n, m.v0);
  const V press = -(state.direction * dot<arithmetic>(start.n, gain));
  const V own = magnitude(press);
  const V rounding = V(4 * eps) * one_norm(m.v0);
  const Mask<V> is_out = out > V(T(0));
  const Mask<V> stays_low = (out <= rounding) | (out * out * magnitude(state.t) <= V(T(2)) * own * low);
  const Mask<V> comes_slow = -out <= own + rounding;
  const Mask<V> is_slow = Mask<V>(has_pulses(surface)) | (is_out & stays_low) | ((!is_out) & comes_slow);
  const V near = V(T(4)) * low + fallen_away<V, arithmetic>(surface, m, state.t);
  const Mask<V> rests = ((start.s <= near) & is_slow) | hovers<V>(surface, start.s, out, press, state.t);
  return select<V>(rests, one, select<V>(is_over, V(T(0)), V(surface.tau)));
}

// A particle after the part f of the remaining step.
template <class V>
struct Moment {
  Three<V> x, v;
};

template <class V, Arithmetic arithmetic, PathForm form>
Moment<V> moment(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, const ImpactState<V, arithmetic, form>& state,
                 const Three<V>& gain, V f) noexcept {
  if constexpr (form == PathForm::parabola) {
    return {along<V, arithmetic>(m.x0, path(surface, m, state.t), f), multiply_add<arithmetic>(f, gain, m.v0)};
  } else {
    const Responses<V> P = (*state.bending)(f * state.left);
    const auto& end = state.end;
    const bool is_driven = state.bending->is_driven();
    const V frequency = quotient<V>(V(Scalar<V>(1)), state.h);
    Three<V> v1 = m.v1;
    if (is_driven) v1 = v1 - frequency * driven<V, arithmetic>(state.drive, end.P2, end.P3, end.P4);
    Moment<V> at;
    for (std::size_t k = 0; k < 3; ++k) {
      const V pull = subtract_product<arithmetic>(v1[k], m.v0[k], end.P0[k]) * inverse(end.P1[k]);
      at.v[k] = multiply_add<arithmetic>(pull, P.P1[k], m.v0[k] * P.P0[k]);
    }
    if (is_driven) at.v = at.v + frequency * driven<V, arithmetic>(state.drive, P.P2, P.P3, P.P4);
    at.x = surface.sweep == ContactPath::line ? along<V, arithmetic>(m.x0, path(surface, m, state.t), f)
                                              : m.x0 + flow_path<V, arithmetic>(m, state).way(P);
    return at;
  }
}

// The normal and the velocity of a surface where it meets lanes at x, t before the end.
template <class V>
struct Meeting {
  Three<V> n, v;
};

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Meeting<V> meeting(const Surface<Scalar<V>>& surface, const Three<V>& x, V t) noexcept {
  const Three<V> n = touch<V, arithmetic>(surface, taken_along<V, arithmetic>(surface, x, t)).n;
  const Three<V> v = velocity_at<V, arithmetic>(surface, x, t);
  if (surface.movement != Movement::turns) return {n, v};
  return {turned_by<V, arithmetic>(negative(t) * three<V>(surface.omega), n), v};
}

template <class V, Arithmetic arithmetic, PathForm form>
void respond(const Surface<Scalar<V>>& surface, Trajectory<V>& m, ImpactState<V, arithmetic, form>& state, V f, Mask<V> hits,
             Pressed<V>* latest) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const Three<V> gain = m.v1 - m.v0;
  const auto [xf, vf] = moment<V, arithmetic, form>(surface, m, state, gain, f);
  const V rest = one - f;
  const V t = rest * state.t;
  const bool moves = surface.movement != Movement::rest;
  Meeting<V> met;
  if (moves) {
    met = meeting<V, arithmetic>(surface, xf, t);
  } else {
    met.n = touch<V, arithmetic>(surface, xf).n;
  }
  const Three<V> n = met.n;
  const Three<V> vr = moves ? vf - met.v : vf;
  const V vn = dot<arithmetic>(n, vr);
  const Mask<V> acts = hits & (state.direction * vn <= zero);
  if (latest != nullptr && surface.e == 0) {
    latest->by = select<V>(acts, state.last, latest->by);
    latest->removed = select<V>(acts, magnitude(vn), latest->removed);
    latest->v = select(acts, vf, latest->v);
  }

  // An impact whose bounces would all end within the step is the last one. `forces` excludes the surfaces that held a lane up
  // to here, and their friction.
  const Mask<V> was_held = state.supports.a >= zero;
  const Three<V> forces = select(was_held, gain - state.supports.dv, gain);
  const V pressed = rest * (state.direction * dot<arithmetic>(n, forces));
  const Mask<V> is_over = V(surface.e + surface.e) * magnitude(vn) <= V(surface.e - 1) * pressed;
  const bool may_settle = surface.response == Response::resume && surface.e > 0;
  const V e = may_settle ? select<V>(is_over, zero, V(surface.e)) : V(surface.e);
  Trajectory<V> room;
  const V tau = kept_by_viscosity<V, arithmetic, form>(surface, seen_from<V, arithmetic>(surface, m, state.t, room), state,
                                                       gain, may_settle ? is_over : Mask<V>(false));
  const Three<V> vt = tau * subtract_product<arithmetic>(vr, vn, n);
  const V slide = V(surface.mu) * ((one + e) * magnitude(vn));
  const V kept = surface.mu == 0 ? one : kept_by_friction(slide, slide, square_root(dot<arithmetic>(vt, vt)));
  const Three<V> away = subtract_product<arithmetic>(kept * vt, e * vn, n);
  const Three<V> after = moves ? away + met.v : away;

  // Surfaces that held a lane up to here need not hold it in the rest of the step.
  const Three<V> x1 = select(was_held, subtract_product<arithmetic>(m.x1, rest * rest, state.supports.dx), m.x1);
  const Three<V> way = x1 - xf;
  const V beyond = dot<arithmetic>(n, moves ? subtract_product<arithmetic>(way, t, met.v) : way);
  Three<V> moved = subtract_product<arithmetic>(x1, beyond, n);
  Three<V> v1;
  if constexpr (form == PathForm::parabola) {
    if (surface.response == Response::resume) moved = multiply_add<arithmetic>(t, after - vf, x1);
    v1 = multiply_add<arithmetic>(rest, gain, after);
  } else {
    const V left = rest * state.left;
    const Responses<V> P = (*state.bending)(left);
    for (std::size_t k = 0; k < 3; ++k) {
      const V pulse = after[k] - vf[k];
      if (surface.response == Response::resume) moved[k] = multiply_add<arithmetic>(state.h * P.P1[k], pulse, x1[k]);
      v1[k] = multiply_add<arithmetic>(P.P0[k], pulse, m.v1[k]);
    }
    if (state.bending->is_driven()) {
      const V passed = f * state.left;
      const Drive<V>& drive = state.drive;
      const Three<V> D2 = multiply_add<arithmetic>(passed, drive.D3, drive.D2);
      const V half = V(Scalar<V>(0.5)) * passed;
      const Three<V> D1 = multiply_add<arithmetic>(passed, multiply_add<arithmetic>(half, drive.D3, drive.D2), drive.D1);
      state.drive = {select(hits, D1, drive.D1), select(hits, D2, drive.D2), drive.D3};
    }
    state.left = select<V>(hits, left, state.left);
    state.end = select(hits, P, state.end);
  }
  v1 = select(was_held, subtract_product<arithmetic>(v1, rest, state.supports.dv), v1);

  m.x1 = select(acts, moved, select(hits, x1, m.x1));
  m.v1 = select(acts, v1, select(hits & was_held, subtract_product<arithmetic>(m.v1, rest, state.supports.dv), m.v1));
  m.x0 = select(hits, xf, m.x0);
  m.v0 = select(acts, after, select(hits, vf, m.v0));
  state.t = select<V>(hits, t, state.t);
}

}  // namespace
}  // namespace dvdx
