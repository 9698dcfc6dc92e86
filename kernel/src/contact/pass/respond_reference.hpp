// The response to an impact, scalar: restitution, friction, viscosity. Written by hand beside respond.inl.hpp.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

#include "contact/pass/push_out_reference.hpp"
#include "contact/pass/rest_reference.hpp"
#include "contact/pass/time_of_impact_reference.hpp"
#include "contact/pass/touch_test_reference.hpp"

namespace dvdx::reference {

// Returns how far off a curved surface the springs of a network may have left a particle that lies on it.
template <Arithmetic arithmetic, class T>
T fallen_away(const Surface<T>& surface, const Particle<T>& p, T t) noexcept {
  return surface.falls_away * (t * t * dot<arithmetic>(p.v0, p.v0));
}

// Whether a particle of a network is as low over a surface, and comes as slowly, as one that rests there between pulses. out:
// its velocity away from the surface; press: the velocity towards it that forces other than springs give until the flow's end.
template <class T>
bool hovers(const Surface<T>& surface, T s, T out, T press, T t) noexcept {
  const T fall = surface.flows_per_substep * press;
  return has_pulses(surface) && s <= T(0.5) * surface.flows_per_substep * fall * std::abs(t) && -out <= fall;
}

// Returns the part of the tangential velocity that an impact leaves: 1 for a particle that already lay or slid on the surface.
template <Arithmetic arithmetic, PathForm form, class T>
T kept_by_viscosity(const Surface<T>& surface, const Particle<T>& p, const ImpactState<arithmetic, form, T>& state,
                    const Vector<T>& gain, bool is_over) noexcept {
  if (surface.tau == 1) return 1;
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const Touch<T> start = touch<arithmetic>(surface, p.x0);
  const T low = low_bounce * eps * (one_norm(p.x0) + surface.radius);
  const T out = state.direction * dot<arithmetic>(start.n, p.v0);
  const T press = -(state.direction * dot<arithmetic>(start.n, gain));
  const T own = std::abs(press);
  const T rounding = 4 * eps * one_norm(p.v0);
  const bool stays_low = out <= rounding || out * out * std::abs(state.t) <= 2 * own * low;
  const bool comes_slow = -out <= own + rounding;
  const bool is_slow = has_pulses(surface) || (out > 0 ? stays_low : comes_slow);
  const bool lies = start.s <= 4 * low + fallen_away<arithmetic>(surface, p, state.t) && is_slow;
  const bool rests = lies || hovers(surface, start.s, out, press, state.t);
  return rests ? T(1) : is_over ? T(0) : surface.tau;
}

template <class T>
struct Moment {
  Vector<T> x, v;
};

template <Arithmetic arithmetic, PathForm form, class T>
Moment<T> moment(const Surface<T>& surface, const Particle<T>& p, const ImpactState<arithmetic, form, T>& state,
                 const Vector<T>& gain, T f) noexcept {
  Moment<T> at;
  if constexpr (form == PathForm::parabola) {
    at.x = along<arithmetic>(p.x0, path(surface, p, state.t), f);
    for (std::size_t k = 0; k < 3; ++k) at.v[k] = multiply_add<arithmetic>(f, gain[k], p.v0[k]);
    return at;
  } else {
    const Responses<T> P = (*state.bending)(f * state.left);
    const auto& end = state.end;
    const bool is_driven = state.bending->is_driven();
    const T frequency = 1 / state.h;
    const Vector<T> drive_end = driven<arithmetic>(state.drive, end.P2, end.P3, end.P4);
    const Vector<T> drive_here = driven<arithmetic>(state.drive, P.P2, P.P3, P.P4);
    for (std::size_t k = 0; k < 3; ++k) {
      const T v1 = is_driven ? p.v1[k] - frequency * drive_end[k] : p.v1[k];
      const T pull = subtract_product<arithmetic>(v1, p.v0[k], end.P0[k]) * inverse(end.P1[k]);
      at.v[k] = multiply_add<arithmetic>(pull, P.P1[k], p.v0[k] * P.P0[k]);
      if (is_driven) at.v[k] = at.v[k] + frequency * drive_here[k];
    }
    if (surface.sweep == ContactPath::line) {
      at.x = along<arithmetic>(p.x0, path(surface, p, state.t), f);
      return at;
    }
    const Vector<T> way = flow_path(p, state).way(P);
    for (std::size_t k = 0; k < 3; ++k) at.x[k] = p.x0[k] + way[k];
    return at;
  }
}

// The normal and the velocity of a surface where it meets a particle at x, t before the end.
template <class T>
struct Meeting {
  Vector<T> n, V{};
};

template <Arithmetic arithmetic, class T>
Meeting<T> meeting(const Surface<T>& surface, const Vector<T>& x, T t) noexcept {
  if (surface.movement == Movement::rest) return {touch<arithmetic>(surface, x).n};
  const Vector<T> n = touch<arithmetic>(surface, taken_along<arithmetic>(surface, x, t)).n;
  const Vector<T> V = velocity_at<arithmetic>(surface, x, t);
  if (surface.movement != Movement::turns) return {n, V};
  return {turned_by<arithmetic>(scaled_by(-t, surface.omega), n), V};
}

// Whether a particle lies on a surface and is pressed onto it from here on. In a resting sheet, each pulse of springs presses a
// particle, or lifts it so little that it is back within the sub-step.
template <Arithmetic arithmetic, PathForm form, class T>
bool is_pressed_on(const Surface<T>& surface, const Particle<T>& p, const ImpactState<arithmetic, form, T>& state) noexcept {
  const Particle<T> seen = seen_from<arithmetic>(surface, p, state.t);
  const Touch<T> start = touch<arithmetic>(surface, seen.x0);
  const T sizes = (one_norm(seen.x0) + one_norm(p.x1)) + (surface.radius + surface.radius);
  const T roundings = surface.movement == Movement::rest ? 2 : 8;
  const T near = roundings * std::numeric_limits<T>::epsilon() * sizes + fallen_away<arithmetic>(surface, seen, state.t);
  const T out = state.direction * dot<arithmetic>(start.n, seen.v0);
  const T press = -(state.direction * dot<arithmetic>(start.n, difference(p.v1, p.v0)));
  return (start.s <= near && (has_pulses(surface) || out <= 0)) || hovers(surface, start.s, out, press, state.t);
}

template <Arithmetic arithmetic, PathForm form, class T>
void respond(const Surface<T>& surface, Particle<T>& p, ImpactState<arithmetic, form, T>& state, T f) noexcept {
  const bool lies = state.recording != nullptr && is_pressed_on(surface, p, state);
  if (state.recording != nullptr) state.recording->let_go(f);
  const Vector<T> gain = difference(p.v1, p.v0);
  const auto [xf, vf] = moment(surface, p, state, gain, f);
  const T rest = 1 - f;
  const auto [n, V] = meeting<arithmetic>(surface, xf, rest * state.t);
  const bool moves = surface.movement != Movement::rest;
  const Vector<T> vr = moves ? difference(vf, V) : vf;
  const T vn = dot<arithmetic>(n, vr);
  const Vector<T> forces = state.supports.a != Supports<T>::none ? difference(gain, state.supports.dv) : gain;
  const T pressed = rest * (state.direction * dot<arithmetic>(n, forces));
  const bool is_over = surface.response == Response::resume && surface.e > 0 &&
                       (surface.e + surface.e) * std::abs(vn) <= (surface.e - 1) * pressed;
  const T e = is_over ? T(0) : surface.e;
  const T tau = kept_by_viscosity(surface, seen_from<arithmetic>(surface, p, state.t), state, gain, is_over);
  state.t = rest * state.t;
  if constexpr (form == PathForm::flow) {
    const T passed = f * state.left;
    const T half = T(0.5) * passed;
    auto& [D1, D2, D3] = state.drive;
    for (std::size_t k = 0; k < 3 && state.bending->is_driven(); ++k) {
      D1[k] = multiply_add<arithmetic>(passed, multiply_add<arithmetic>(half, D3[k], D2[k]), D1[k]);
      D2[k] = multiply_add<arithmetic>(passed, D3[k], D2[k]);
    }
    state.left = rest * state.left;
    state.end = (*state.bending)(state.left);
  }
  p.x0 = xf;
  p.v0 = vf;
  state.pressed.by = Supports<T>::none;
  const auto let_go = [&] {
    if (state.supports.a == Supports<T>::none) return;
    for (std::size_t k = 0; k < 3; ++k) p.v1[k] = subtract_product<arithmetic>(p.v1[k], rest, state.supports.dv[k]);
  };
  if (state.supports.a != Supports<T>::none) {
    for (std::size_t k = 0; k < 3; ++k) p.x1[k] = subtract_product<arithmetic>(p.x1[k], rest * rest, state.supports.dx[k]);
  }
  if (!(state.direction * vn <= 0)) return let_go();
  if (has_pulses(surface) && surface.e == 0) state.pressed = {state.last, std::abs(vn), vf};

  Vector<T> vt;
  for (std::size_t k = 0; k < 3; ++k) vt[k] = tau * subtract_product<arithmetic>(vr[k], vn, n[k]);
  const T slide = surface.mu * ((1 + e) * std::abs(vn));
  const T kept = kept_by_friction(slide, slide, std::sqrt(dot<arithmetic>(vt, vt)));
  Vector<T> way = difference(p.x1, xf);
  for (std::size_t k = 0; k < 3 && moves; ++k) way[k] = subtract_product<arithmetic>(way[k], state.t, V[k]);
  const T beyond = dot<arithmetic>(n, way);
  for (std::size_t k = 0; k < 3; ++k) {
    T after = subtract_product<arithmetic>(kept * vt[k], e * vn, n[k]);
    if (moves) after = after + V[k];
    const T pulse = after - vf[k];
    if (surface.response == Response::end_on_surface) {
      p.x1[k] = subtract_product<arithmetic>(p.x1[k], beyond, n[k]);
    } else if (form == PathForm::parabola) {
      p.x1[k] = multiply_add<arithmetic>(state.t, pulse, p.x1[k]);
    } else {
      p.x1[k] = multiply_add<arithmetic>(state.h * state.end.P1[k], pulse, p.x1[k]);
    }
    p.v1[k] = form == PathForm::parabola ? multiply_add<arithmetic>(rest, gain[k], after)
                                         : multiply_add<arithmetic>(state.end.P0[k], pulse, p.v1[k]);
    p.v0[k] = after;
  }
  if (state.recording != nullptr) {
    const Vector<T> dv = difference(p.v0, vf);
    const bool hits = dv != Vector<T>{} && !(lies && (e == 0 || has_pulses(surface)));
    state.recording->push(hits ? EventKind::impact : EventKind::hold, state.last, xf, n, dv, state.t);
  }
  let_go();
}

}  // namespace dvdx::reference
