// Impacts in the order of time, scalar: written by hand beside impact.inl.hpp.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

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

template <Arithmetic arithmetic, PathForm form, class T>
std::optional<T> cross(const Terms<T>& terms, const Surface<T>& surface, const Particle<T>& p,
                       const ImpactState<arithmetic, form, T>& state, bool is_held, T low) noexcept {
  const Particle<T> seen = seen_from<arithmetic>(surface, p, state.t);
  switch (surface.shape) {
    case Shape::plane:
      return cross_plane(terms, surface, seen, p, state, is_held, low);
    case Shape::sphere:
      return cross_sphere(terms, surface, seen, p, state, is_held, low);
    case Shape::capsule:
    case Shape::box:
    case Shape::convex:
    case Shape::mesh:
      break;
  }
  return cross_solid(surface, seen, p, state, is_held, low);
}

// A particle was pressed onto a surface b and, after the part f of the remaining step, onto a. Resolves both together.
template <Arithmetic arithmetic, PathForm form, class T>
void settle_in_edge(const Terms<T>& terms, const Pressed<T>& before, T f, Particle<T>& p,
                    ImpactState<arithmetic, form, T>& state) noexcept {
  constexpr T eps = std::numeric_limits<T>::epsilon();
  if (before.by == Supports<T>::none || state.pressed.by == Supports<T>::none || before.by == state.pressed.by) return;
  const Surface<T>& a = terms.surfaces[state.pressed.by];
  const Surface<T>& b = terms.surfaces[before.by];
  const auto distance = [&](const Surface<T>& surface) {
    const bool moves = surface.movement != Movement::rest;
    return touch<arithmetic>(surface, moves ? taken_along<arithmetic>(surface, p.x0, state.t) : p.x0).s;
  };
  const T sb = distance(b);
  const T way = std::abs(terms.h) * one_norm(before.v);
  const T sizes = ((one_norm(p.x0) + one_norm(p.x1)) + (b.radius + b.radius)) + way;
  const T near = 8 * eps * sizes + b.falls_away * (way * way);
  if (!(sb <= near)) return;
  const Meeting<T> of_a = meeting<arithmetic>(a, p.x0, state.t);
  const Meeting<T> of_b = meeting<arithmetic>(b, p.x0, state.t);
  const T kappa = dot<arithmetic>(of_a.n, of_b.n);
  const T det = subtract_product<arithmetic>(T(1), kappa, kappa);
  if (!(det > 64 * eps)) return;
  const T scale = 1 / det;
  const bool is_at_once = f <= 16 * eps;
  const T flat = most_pulses * (1 - kappa);
  const T reach = (before.removed + before.removed) * (flat < 1 ? flat : T(1));
  if (!is_at_once && kappa > 0 && !(state.pressed.removed <= reach)) return;

  const Vector<T> across = [&] {  // to b, along a
    Vector<T> to;
    for (std::size_t k = 0; k < 3; ++k) to[k] = scale * subtract_product<arithmetic>(of_b.n[k], kappa, of_a.n[k]);
    return to;
  }();
  const T share = dot<arithmetic>(of_b.n, difference(of_b.V, of_a.V));
  Vector<T> V;
  for (std::size_t k = 0; k < 3; ++k) V[k] = multiply_add<arithmetic>(share, across[k], of_a.V[k]);
  const Vector<T> u = difference(is_at_once ? before.v : p.v0, V);
  const T ua = state.direction * dot<arithmetic>(of_a.n, u);
  const T ub = state.direction * dot<arithmetic>(of_b.n, u);
  Two<T> taken{scale * (kappa * ub - ua), scale * (kappa * ua - ub)};
  if (is_at_once && !(taken.b >= 0 && taken.a >= 0)) {
    taken = taken.b >= 0 ? Two<T>{0, ub < 0 ? -ub : T(0)} : Two<T>{ua < 0 ? -ua : T(0), 0};
  }
  const bool is_edge = taken.a != 0 && taken.b != 0;
  Vector<T> along;
  for (std::size_t k = 0; k < 3; ++k) {
    const T by_a = multiply_add<arithmetic>(state.direction * taken.a, of_a.n[k], u[k]);
    along[k] = multiply_add<arithmetic>(state.direction * taken.b, of_b.n[k], by_a);
  }
  // In a flat edge both pulses are large against the velocity left. Friction would act on their rounding errors: solve again.
  const T left_a = dot<arithmetic>(of_a.n, along);
  const T left_b = dot<arithmetic>(of_b.n, along);
  const T more_a = is_edge ? scale * (kappa * left_b - left_a) : T(0);
  const T more_b = is_edge ? scale * (kappa * left_a - left_b) : T(0);
  for (std::size_t k = 0; k < 3; ++k) {
    along[k] = multiply_add<arithmetic>(more_b, of_b.n[k], multiply_add<arithmetic>(more_a, of_a.n[k], along[k]));
  }
  const T pressed_a = taken.a > 0 ? taken.a : T(0);
  const T pressed_b = taken.b > 0 ? taken.b : T(0);
  const T slide = multiply_add<arithmetic>(b.mu, pressed_b, a.mu * pressed_a);
  const T hold = multiply_add<arithmetic>(b.hold, pressed_b, a.hold * pressed_a);
  const T kept = kept_by_friction(slide, hold, std::sqrt(dot<arithmetic>(along, along)));
  const T sa = distance(a);
  const T onto_a = is_edge ? scale * (kappa * sb - sa) : T(0);
  const T onto_b = is_edge ? scale * (kappa * sa - sb) : T(0);
  const Vector<T> told = p.v0;
  for (std::size_t k = 0; k < 3; ++k) {
    const T shift = multiply_add<arithmetic>(onto_b, of_b.n[k], onto_a * of_a.n[k]);
    const T after = multiply_add<arithmetic>(kept, along[k], V[k]);
    const T pulse = after - p.v0[k];
    p.x0[k] = p.x0[k] + shift;
    p.x1[k] = p.x1[k] + shift;
    if constexpr (form == PathForm::parabola) {
      p.x1[k] = multiply_add<arithmetic>(state.t, pulse, p.x1[k]);
      p.v1[k] = after + (p.v1[k] - p.v0[k]);
    } else {
      p.x1[k] = multiply_add<arithmetic>(state.h * state.end.P1[k], pulse, p.x1[k]);
      p.v1[k] =
          multiply_add<arithmetic>(state.end.P0[k], after, subtract_product<arithmetic>(p.v1[k], state.end.P0[k], p.v0[k]));
    }
    p.v0[k] = after;
  }
  state.pressed.v = p.v0;
  if (state.recording == nullptr) return;
  // Both impacts are logged already. The rest is split by the multiples of the normals, its friction by the friction limits.
  const Vector<T> rest = difference(p.v0, told);
  const T rest_a = dot<arithmetic>(of_a.n, rest);
  const T rest_b = dot<arithmetic>(of_b.n, rest);
  const T by_a = scale * (rest_a - kappa * rest_b);
  const T by_b = scale * (rest_b - kappa * rest_a);
  const T share_b = hold > 0 ? b.hold * pressed_b / hold : T(0.5);
  Vector<T> dv_a, dv_b;
  for (std::size_t k = 0; k < 3; ++k) {
    const T along_edge = rest[k] - by_a * of_a.n[k] - by_b * of_b.n[k];
    dv_b[k] = by_b * of_b.n[k] + share_b * along_edge;
    dv_a[k] = rest[k] - dv_b[k];
  }
  state.recording->push(EventKind::hold, state.last, p.x0, of_a.n, dv_a, state.t);
  state.recording->push(EventKind::hold, before.by, p.x0, of_b.n, dv_b, state.t);
}

// Returns whether there was an impact.
template <Arithmetic arithmetic, PathForm form, class T>
bool resolve_earliest(const Terms<T>& terms, Particle<T>& p, ImpactState<arithmetic, form, T>& state) noexcept {
  const T low = 4 * low_bounce * std::numeric_limits<T>::epsilon() * one_norm(p.x0);
  const T corner = terms.bend.corner * state.t;
  Vector<T> middle;
  for (std::size_t k = 0; k < 3; ++k) middle[k] = multiply_add<arithmetic>(corner, p.v0[k], p.x0[k]);
  T earliest = 2;
  std::size_t which = terms.surface_count;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    if (state.supports.has(j) || !may_touch_moving<arithmetic>(surface, p, middle, state.t, corner)) continue;
    if (leaves(surface, state)) continue;
    const std::optional<T> f = cross(terms, surface, p, state, state.last == j, low);
    if (f && *f < earliest) {
      earliest = *f;
      which = j;
    }
  }
  if (which == terms.surface_count) return false;
  state.last = which;
  const Pressed<T> before = state.pressed;
  respond(terms.surfaces[which], p, state, earliest);
  settle_in_edge(terms, before, earliest, p, state);
  hold(terms, p, state);
  return true;
}

template <Arithmetic arithmetic, PathForm form, class T>
void clamp(const Surface<T>& surface, Particle<T>& p, const ImpactState<arithmetic, form, T>& state, bool is_held,
           T size) noexcept {
  const Vector<T> n = touch<arithmetic>(surface, p.x1).n;
  Particle<T> seen = seen_from<arithmetic>(surface, p, state.t);
  const T vn = dot<arithmetic>(n, seen.v1);
  if (state.direction * vn < 0) {
    const T removed = std::abs(vn);
    Vector<T> vt;
    for (std::size_t k = 0; k < 3; ++k) vt[k] = subtract_product<arithmetic>(seen.v1[k], vn, n[k]);
    const T kept = kept_by_friction(surface.mu * removed, surface.hold * removed, std::sqrt(dot<arithmetic>(vt, vt)));
    for (std::size_t k = 0; k < 3; ++k) seen.v1[k] = kept * vt[k];
    if (surface.movement == Movement::rest) p.v1 = seen.v1;
  }
  const Vector<T> sum = sum_of(seen.v0, seen.v1);
  const T motion = std::abs(state.t) * one_norm(sum);
  const bool rests = is_held && state.leaving == nullptr && motion < std::numeric_limits<T>::epsilon() / 4 * size;
  const Vector<T> base = rests ? seen.x0 : p.x1;
  const Touch<T> there = touch<arithmetic>(surface, base);
  for (std::size_t k = 0; k < 3; ++k) p.x1[k] = subtract_product<arithmetic>(base[k], there.s, there.n[k]);
  if (surface.movement == Movement::rest || !(state.direction * vn < 0)) return;
  p.v1 = sum_of(seen.v1, velocity_at<arithmetic>(surface, p.x1, T(0)));
}

// A particle on `a` is inside `b`. If the surfaces face each other and leave it no room at the start either, moves it to the
// middle, with friction. Returns whether it did.
template <Arithmetic arithmetic, PathForm form, class T>
bool is_pinched(const Surface<T>& a, const Surface<T>& b, Particle<T>& p,
                const ImpactState<arithmetic, form, T>& state) noexcept {
  const Touch<T> end_a = touch<arithmetic>(a, p.x1);
  const Touch<T> end_b = touch<arithmetic>(b, p.x1);
  const T kappa = dot<arithmetic>(end_a.n, end_b.n);
  const T opening = 1 - kappa;
  if (!face_each_other(a.mu, b.mu, kappa)) return false;
  const Particle<T> from_a = seen_from<arithmetic>(a, p, state.t);
  const Particle<T> from_b = seen_from<arithmetic>(b, p, state.t);
  const T sizes = (one_norm(p.x0) + one_norm(p.x1)) + (a.radius + b.radius);
  const T room = touch<arithmetic>(a, from_a.x0).s + touch<arithmetic>(b, from_b.x0).s;
  if (!(room < -(8 * std::numeric_limits<T>::epsilon() * sizes))) return false;

  const T half = T(0.5) * inverse(opening);
  const Vector<T> axis = difference(end_a.n, end_b.n);
  Vector<T> V, x;
  for (std::size_t k = 0; k < 3; ++k) {
    V[k] = T(0.5) * ((p.v1[k] - from_a.v1[k]) + (p.v1[k] - from_b.v1[k]));
    x[k] = T(0.5) * (from_a.x0[k] + from_b.x0[k]);
  }
  if (a.mu + b.mu > 0) {
    p.v1 = V;
  } else {
    const Vector<T> u = difference(p.v1, V);
    const T across = half * dot<arithmetic>(axis, u);
    for (std::size_t k = 0; k < 3; ++k) p.v1[k] = V[k] + subtract_product<arithmetic>(u[k], across, axis[k]);
    x = p.x1;
  }
  const Touch<T> at_a = touch<arithmetic>(a, x);
  const Touch<T> at_b = touch<arithmetic>(b, x);
  const T shift = half * (at_b.s - at_a.s);
  for (std::size_t k = 0; k < 3; ++k) p.x1[k] = multiply_add<arithmetic>(shift, axis[k], x[k]);
  return true;
}

template <Arithmetic arithmetic, PathForm form, class T>
void resolve_all(const Terms<T>& terms, Particle<T>& p, ImpactState<arithmetic, form, T>& state) noexcept {
  Leaving<T> leaving;
  if (terms.pushes) push_out(terms, p, state, leaving);
  hold(terms, p, state);
  for (int impact = 0; impact < terms.impacts; ++impact) {
    if (!resolve_earliest(terms, p, state)) break;
  }
  if (state.recording != nullptr) state.recording->let_go(1);
  T tolerance = 0;
  std::size_t before = terms.surface_count;
  for (int round = 0; round < clamp_rounds; ++round) {
    bool is_clamped = false;
    for (std::size_t j = 0; j < terms.surface_count; ++j) {
      const T size = one_norm(p.x1);
      const bool is_held = state.supports.has(j);
      if (round == 0 && is_held && terms.surfaces[j].shape == Shape::plane) continue;
      if (!(touch<arithmetic>(terms.surfaces[j], p.x1).s < -(tolerance * size))) continue;
      if (leaves(terms.surfaces[j], state)) continue;
      is_clamped = true;
      const Vector<T> v = p.v1;
      const bool ends =
          before != terms.surface_count && before != j && is_pinched(terms.surfaces[before], terms.surfaces[j], p, state);
      if (!ends) clamp(terms.surfaces[j], p, state, state.last == j || is_held, size);
      if (state.recording != nullptr) {
        const Vector<T> dv = difference(p.v1, v);
        const T own = terms.surfaces[j].hold;
        const Vector<T> dv_j = ends ? scaled_by(own / (own + terms.surfaces[before].hold), dv) : dv;
        state.recording->push(EventKind::hold, j, p.x1, {}, dv_j, T(0));
        if (ends) state.recording->push(EventKind::hold, before, p.x1, {}, difference(dv, dv_j), T(0));
      }
      if (ends) return;
      before = j;
    }
    if (!is_clamped) return;
    tolerance = 2 * std::numeric_limits<T>::epsilon();
  }
}

}  // namespace dvdx::reference
