// Impacts in the order of time, wide. The scalar twin: impact_reference.hpp.
#pragma once

#include <cstddef>
#include <limits>

#include "contact/pass/push_out.inl.hpp"
#include "contact/pass/rest.inl.hpp"
#include "contact/pass/time_of_impact.inl.hpp"
#include "contact/pass/touch_test.inl.hpp"

namespace dvdx {
namespace {

// How far off a curved surface the springs of a network may have left what lies on it.
template <class V, Arithmetic arithmetic>
V fallen_away(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, V t) noexcept {
  return V(surface.falls_away) * (t * t * dot<arithmetic>(m.v0, m.v0));
}

// Whether lanes of a network are as low over a surface, and come to it as slowly, as what rests there between pulses.
template <class V>
Mask<V> hovers(const Surface<Scalar<V>>& surface, V s, V out, V press, V t) noexcept {
  const V flows(surface.flows_per_substep);
  const V fall = flows * press;
  return Mask<V>(has_pulses(surface)) & (s <= V(Scalar<V>(0.5)) * flows * fall * magnitude(t)) & (-out <= fall);
}

// The share of the tangential velocity that is left at an impact, and after infinitely many that end within the step. 1 for
// lanes that lay or slid on the surface before.
template <class V, Arithmetic arithmetic, PathForm form>
V kept_by_viscosity(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, const Course<V, arithmetic, form>& course,
                    const Three<V>& gain, Mask<V> is_over) noexcept {
  using T = Scalar<V>;
  const V one(T(1));
  if (surface.tau == 1) return one;
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const Touch<V> start = touch<V, arithmetic>(surface, m.x0);
  const V low = V(low_bounce * eps) * (one_norm(m.x0) + V(surface.radius));
  const V out = course.direction * dot<arithmetic>(start.n, m.v0);
  const V press = -(course.direction * dot<arithmetic>(start.n, gain));
  const V own = magnitude(press);
  const V rounding = V(4 * eps) * one_norm(m.v0);
  const Mask<V> is_out = out > V(T(0));
  const Mask<V> stays_low = (out <= rounding) | (out * out * magnitude(course.t) <= V(T(2)) * own * low);
  const Mask<V> comes_slow = -out <= own + rounding;
  const Mask<V> is_slow = Mask<V>(has_pulses(surface)) | (is_out & stays_low) | ((!is_out) & comes_slow);
  const V near = V(T(4)) * low + fallen_away<V, arithmetic>(surface, m, course.t);
  const Mask<V> rests = ((start.s <= near) & is_slow) | hovers<V>(surface, start.s, out, press, course.t);
  return select<V>(rests, one, select<V>(is_over, V(T(0)), V(surface.tau)));
}

// A particle at the part f of what remains.
template <class V>
struct Moment {
  Three<V> x, v;
};

template <class V, Arithmetic arithmetic, PathForm form>
Moment<V> moment(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, const Course<V, arithmetic, form>& course,
                 const Three<V>& gain, V f) noexcept {
  if constexpr (form == PathForm::parabola) {
    return {along<V, arithmetic>(m.x0, path(surface, m, course.t), f), multiply_add<arithmetic>(f, gain, m.v0)};
  } else {
    const Responses<V> P = (*course.bending)(f * course.left);
    const auto& end = course.end;
    const bool is_driven = course.bending->is_driven();
    const V frequency = quotient<V>(V(Scalar<V>(1)), course.h);
    Three<V> v1 = m.v1;
    if (is_driven) v1 = v1 - frequency * driven<V, arithmetic>(course.drive, end.P2, end.P3, end.P4);
    Moment<V> at;
    for (std::size_t k = 0; k < 3; ++k) {
      const V pull = subtract_product<arithmetic>(v1[k], m.v0[k], end.P0[k]) * inverse(end.P1[k]);
      at.v[k] = multiply_add<arithmetic>(pull, P.P1[k], m.v0[k] * P.P0[k]);
    }
    if (is_driven) at.v = at.v + frequency * driven<V, arithmetic>(course.drive, P.P2, P.P3, P.P4);
    at.x = surface.sweep == ContactPath::line ? along<V, arithmetic>(m.x0, path(surface, m, course.t), f)
                                              : m.x0 + flow_path<V, arithmetic>(m, course).way(P);
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
void respond(const Surface<Scalar<V>>& surface, Trajectory<V>& m, Course<V, arithmetic, form>& course, V f, Mask<V> hits,
             Pressed<V>* latest) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const Three<V> gain = m.v1 - m.v0;
  const auto [xf, vf] = moment<V, arithmetic, form>(surface, m, course, gain, f);
  const V rest = one - f;
  const V t = rest * course.t;
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
  const Mask<V> acts = hits & (course.direction * vn <= zero);
  if (latest != nullptr && surface.e == 0) {
    latest->by = select<V>(acts, course.last, latest->by);
    latest->removed = select<V>(acts, magnitude(vn), latest->removed);
    latest->v = select(acts, vf, latest->v);
  }

  // An impact whose bounces would all be over within the step is the last of them. The surfaces that hold a lane up to here,
  // and their friction, do not press.
  const Mask<V> was_held = course.held.a >= zero;
  const Three<V> forces = select(was_held, gain - course.held.dv, gain);
  const V pressed = rest * (course.direction * dot<arithmetic>(n, forces));
  const Mask<V> is_over = V(surface.e + surface.e) * magnitude(vn) <= V(surface.e - 1) * pressed;
  const bool may_settle = surface.response == Response::resume && surface.e > 0;
  const V e = may_settle ? select<V>(is_over, zero, V(surface.e)) : V(surface.e);
  Trajectory<V> room;
  const V tau = kept_by_viscosity<V, arithmetic, form>(surface, seen_from<V, arithmetic>(surface, m, course.t, room), course,
                                                       gain, may_settle ? is_over : Mask<V>(false));
  const Three<V> vt = tau * subtract_product<arithmetic>(vr, vn, n);
  const V slide = V(surface.mu) * ((one + e) * magnitude(vn));
  const V kept = surface.mu == 0 ? one : kept_by_friction(slide, slide, square_root(dot<arithmetic>(vt, vt)));
  const Three<V> away = subtract_product<arithmetic>(kept * vt, e * vn, n);
  const Three<V> after = moves ? away + met.v : away;

  // Surfaces that held a lane up to here need not hold it in the rest.
  const Three<V> x1 = select(was_held, subtract_product<arithmetic>(m.x1, rest * rest, course.held.dx), m.x1);
  const Three<V> way = x1 - xf;
  const V beyond = dot<arithmetic>(n, moves ? subtract_product<arithmetic>(way, t, met.v) : way);
  Three<V> moved = subtract_product<arithmetic>(x1, beyond, n);
  Three<V> v1;
  if constexpr (form == PathForm::parabola) {
    if (surface.response == Response::resume) moved = multiply_add<arithmetic>(t, after - vf, x1);
    v1 = multiply_add<arithmetic>(rest, gain, after);
  } else {
    const V left = rest * course.left;
    const Responses<V> P = (*course.bending)(left);
    for (std::size_t k = 0; k < 3; ++k) {
      const V pulse = after[k] - vf[k];
      if (surface.response == Response::resume) moved[k] = multiply_add<arithmetic>(course.h * P.P1[k], pulse, x1[k]);
      v1[k] = multiply_add<arithmetic>(P.P0[k], pulse, m.v1[k]);
    }
    if (course.bending->is_driven()) {
      const V passed = f * course.left;
      const Drive<V>& drive = course.drive;
      const Three<V> D2 = multiply_add<arithmetic>(passed, drive.D3, drive.D2);
      const V half = V(Scalar<V>(0.5)) * passed;
      const Three<V> D1 = multiply_add<arithmetic>(passed, multiply_add<arithmetic>(half, drive.D3, drive.D2), drive.D1);
      course.drive = {select(hits, D1, drive.D1), select(hits, D2, drive.D2), drive.D3};
    }
    course.left = select<V>(hits, left, course.left);
    course.end = select(hits, P, course.end);
  }
  v1 = select(was_held, subtract_product<arithmetic>(v1, rest, course.held.dv), v1);

  m.x1 = select(acts, moved, select(hits, x1, m.x1));
  m.v1 = select(acts, v1, select(hits & was_held, subtract_product<arithmetic>(m.v1, rest, course.held.dv), m.v1));
  m.x0 = select(hits, xf, m.x0);
  m.v0 = select(acts, after, select(hits, vf, m.v0));
  course.t = select<V>(hits, t, course.t);
}

// Lanes whose path may touch a surface that does not hold them.
template <class V, Arithmetic arithmetic, PathForm form, Surroundings surroundings = Surroundings::any>
class Nearness {
  using T = Scalar<V>;

 public:
  Nearness(const Terms<T>& terms, const Trajectory<V>& m, const Course<V, arithmetic, form>& course) noexcept
      : terms_(terms),
        m_(m),
        course_(course),
        corner_(V(terms.bend.corner) * course.t),
        middle_(multiply_add<arithmetic>(corner_, m.v0, m.x0)) {}

  void watch_ends(Course<V, arithmetic, form>& course, Mask<V> lanes) const noexcept {
    if constexpr (surroundings == Surroundings::planes) return;
    watch(terms_, course, m_.x1, lanes);
    watch(terms_, course, middle_, lanes);
  }

  [[nodiscard]] Mask<V> operator()(std::size_t j) const noexcept {
    const Mask<V> is_near = may_touch(j) & !is_among(course_.held, V(static_cast<T>(j)));
    if constexpr (surroundings == Surroundings::planes) return is_near;
    return is_near & !leaves<V, arithmetic, form>(terms_.surfaces[j], course_);
  }

 private:
  [[nodiscard]] [[gnu::always_inline]] Mask<V> may_touch(std::size_t j) const noexcept {
    const Surface<T>& surface = terms_.surfaces[j];
    if constexpr (surroundings == Surroundings::planes) {
      return may_touch_plane<V, arithmetic>(surface, m_, middle_);
    } else {
      return dvdx::may_touch<V, arithmetic>(surface, m_, middle_, course_.t, corner_);
    }
  }

  const Terms<T>& terms_;
  const Trajectory<V>& m_;
  const Course<V, arithmetic, form>& course_;
  V corner_;
  Three<V> middle_;
};

// Surfaces, one for each lane, as lanes see them where they meet them.
template <class V>
struct Wall {
  V s, mu, hold, radius, falls_away;
  Three<V> n, v;
};

template <class V, Arithmetic arithmetic, PathForm form>
[[gnu::noinline]] Wall<V> met_by(const Terms<Scalar<V>>& terms, const Three<V>& x, const Course<V, arithmetic, form>& course,
                                 V number, Mask<V> lanes) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  Wall<V> met{zero, zero, zero, zero, zero, three<V>(zero), three<V>(zero)};
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const Mask<V> is_it = lanes & (number == V(static_cast<T>(j)));
    if (!any_lane<V>(is_it)) continue;
    const bool moves = surface.movement != Movement::rest;
    const Touch<V> at = touch<V, arithmetic>(surface, moves ? taken_along<V, arithmetic>(surface, x, course.t) : x);
    Meeting<V> meets{at.n, three<V>(zero)};
    if (moves) meets = meeting<V, arithmetic>(surface, x, course.t);
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

// Lanes of a network that have been pressed onto a surface b, and at the part f of what was left then onto another, a: both
// together.
template <class V, Arithmetic arithmetic, PathForm form>
[[gnu::noinline]] void settle_in_edge(const Terms<Scalar<V>>& terms, const Pressed<V>& before, Pressed<V>& pressed, V f,
                                      Trajectory<V>& m, const Course<V, arithmetic, form>& course, Mask<V> lanes) noexcept {
  using T = Scalar<V>;
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const V zero(T(0));
  const V one(T(1));
  lanes = lanes & (before.by >= zero) & (pressed.by >= zero) & differ(before.by, pressed.by);
  if (!any_lane<V>(lanes)) return;
  const Wall<V> b = met_by<V, arithmetic, form>(terms, m.x0, course, before.by, lanes);
  const V way = V(std::abs(terms.h)) * one_norm(before.v);
  const V sizes = ((one_norm(m.x0) + one_norm(m.x1)) + (b.radius + b.radius)) + way;
  const V near = V(8 * eps) * sizes + b.falls_away * (way * way);
  lanes = lanes & (b.s <= near);
  if (!any_lane<V>(lanes)) return;
  const Wall<V> a = met_by<V, arithmetic, form>(terms, m.x0, course, pressed.by, lanes);
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
  const V ua = course.direction * dot<arithmetic>(a.n, u);
  const V ub = course.direction * dot<arithmetic>(b.n, u);
  const V both_a = scale * (kappa * ub - ua);
  const V both_b = scale * (kappa * ua - ub);
  const Mask<V> has_b = both_b >= zero;
  const Mask<V> is_one = is_at_once & !(has_b & (both_a >= zero));
  const V alone_a = select<V>(has_b, zero, select<V>(ua < zero, negative(ua), zero));
  const V alone_b = select<V>(has_b, select<V>(ub < zero, negative(ub), zero), zero);
  const V taken_a = select<V>(is_one, alone_a, both_a);
  const V taken_b = select<V>(is_one, alone_b, both_b);
  const Mask<V> is_edge = differ(taken_a, zero) & differ(taken_b, zero);
  const Three<V> by_a = multiply_add<arithmetic>(course.direction * taken_a, a.n, u);
  const Three<V> rough = multiply_add<arithmetic>(course.direction * taken_b, b.n, by_a);
  // In a flat edge both are large against what is left, along which friction finds their roundings: once more of these.
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
    x1 = multiply_add<arithmetic>(course.t, pulse, x1);
    v1 = after + (m.v1 - m.v0);
  } else {
    for (std::size_t k = 0; k < 3; ++k) {
      const V P0 = course.end.P0[k];
      x1[k] = multiply_add<arithmetic>(course.h * course.end.P1[k], pulse[k], x1[k]);
      v1[k] = multiply_add<arithmetic>(P0, after[k], subtract_product<arithmetic>(m.v1[k], P0, m.v0[k]));
    }
  }
  m.x0 = select(lanes, m.x0 + shift, m.x0);
  m.x1 = select(lanes, x1, m.x1);
  m.v1 = select(lanes, v1, m.v1);
  m.v0 = select(lanes, after, m.v0);
  pressed.v = select(lanes, after, pressed.v);
}

// The earliest impact of every lane; false where none remains. pressed: null where nothing is to be settled in edges.
template <class V, Arithmetic arithmetic, PathForm form>
bool resolve_earliest(const Terms<Scalar<V>>& terms, Trajectory<V>& m, Course<V, arithmetic, form>& course,
                      Pressed<V>* pressed) noexcept {
  using T = Scalar<V>;
  const V low = V(4 * low_bounce * std::numeric_limits<T>::epsilon()) * one_norm(m.x0);
  const Nearness<V, arithmetic, form> near(terms, m, course);
  near.watch_ends(course, course.active);
  V earliest(T(2));
  V which(T(-1));
  Mask<V> any_near(false);
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const V number(static_cast<T>(j));
    const Mask<V> lanes = course.active & near(j);
    if (!any_lane<V>(lanes)) continue;
    any_near = any_near | lanes;
    const Crossing<V> crossing = cross<V, arithmetic, form>(terms, terms.surfaces[j], m, course, course.last == number, low);
    const Mask<V> is_earlier = lanes & crossing.hits & (crossing.f < earliest);
    earliest = select<V>(is_earlier, crossing.f, earliest);
    which = select<V>(is_earlier, number, which);
  }
  course.active = course.active & (which >= V(T(0)));
  course.loose = (course.loose | any_near) & !course.active;
  if (!any_lane<V>(course.active)) return false;
  course.last = select<V>(course.active, which, course.last);
  Pressed<V> before;
  if (pressed != nullptr) {
    before = *pressed;
    pressed->by = select<V>(course.active, V(T(-1)), pressed->by);
  }
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Mask<V> hits = which == V(static_cast<T>(j));
    if (any_lane<V>(hits)) respond<V, arithmetic, form>(terms.surfaces[j], m, course, earliest, hits, pressed);
  }
  if (pressed != nullptr) settle_in_edge<V, arithmetic, form>(terms, before, *pressed, earliest, m, course, course.active);
  hold<V, arithmetic, form>(terms, m, course, course.active);
  return true;
}

template <class V, Arithmetic arithmetic, PathForm form>
void clamp(const Surface<Scalar<V>>& surface, Trajectory<V>& m, const Course<V, arithmetic, form>& course, Mask<V> held,
           Mask<V> inside, V size) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const Three<V> n = touch<V, arithmetic>(surface, m.x1).n;
  Trajectory<V> room;
  const Trajectory<V>& seen = seen_from<V, arithmetic>(surface, m, course.t, room);
  const V vn = dot<arithmetic>(n, seen.v1);
  const V removed = magnitude(vn);
  const Three<V> vt = subtract_product<arithmetic>(seen.v1, vn, n);
  const V length = square_root(dot<arithmetic>(vt, vt));
  const V kept = kept_by_friction(V(surface.mu) * removed, V(surface.hold) * removed, length);
  const Mask<V> is_pressed = inside & (course.direction * vn < zero);
  const Three<V> slower = select(is_pressed, kept * vt, seen.v1);
  const V motion = magnitude(course.t) * one_norm(seen.v0 + slower);
  Mask<V> rests = held & (motion < V(std::numeric_limits<T>::epsilon() / 4) * size);
  if (course.leaving != nullptr) rests = rests & !course.leaving->lanes;
  const Three<V> base = select(rests, seen.x0, m.x1);
  const Touch<V> there = touch<V, arithmetic>(surface, base);
  m.x1 = select(inside, subtract_product<arithmetic>(base, there.s, there.n), m.x1);
  if (surface.movement == Movement::rest) {
    m.v1 = slower;
  } else {
    m.v1 = select(is_pressed, slower + velocity_at<V, arithmetic>(surface, m.x1, V(T(0))), m.v1);
  }
}

// Lanes on `a` are inside b. Where both face each other and have left them no room since the start, they go to the middle
// between them, with their friction. Those that do.
template <class V, Arithmetic arithmetic, PathForm form>
[[gnu::noinline]] Mask<V> pinch(const Surface<Scalar<V>>& a, const Surface<Scalar<V>>& b, Trajectory<V>& m,
                                const Course<V, arithmetic, form>& course, Mask<V> lanes) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  const V half_of(T(0.5));
  const Touch<V> end_a = touch<V, arithmetic>(a, m.x1);
  const Touch<V> end_b = touch<V, arithmetic>(b, m.x1);
  const V kappa = dot<arithmetic>(end_a.n, end_b.n);
  const V opening = one - kappa;
  lanes = lanes & face_each_other<V>(V(a.mu), V(b.mu), kappa);
  if (!any_lane<V>(lanes)) return lanes;
  Trajectory<V> room_a, room_b;
  const Trajectory<V>& from_a = seen_from<V, arithmetic>(a, m, course.t, room_a);
  const Trajectory<V>& from_b = seen_from<V, arithmetic>(b, m, course.t, room_b);
  const V sizes = (one_norm(m.x0) + one_norm(m.x1)) + V(a.radius + b.radius);
  const V room = touch<V, arithmetic>(a, from_a.x0).s + touch<V, arithmetic>(b, from_b.x0).s;
  lanes = lanes & (room < negative(V(8 * std::numeric_limits<T>::epsilon()) * sizes));
  if (!any_lane<V>(lanes)) return lanes;

  const V half = half_of * inverse(opening);
  const Three<V> axis = end_a.n - end_b.n;
  const Three<V> v = half_of * ((m.v1 - from_a.v1) + (m.v1 - from_b.v1));
  const Three<V> carried = half_of * (from_a.x0 + from_b.x0);
  const Three<V> u = m.v1 - v;
  const V across = half * dot<arithmetic>(axis, u);
  const Three<V> along = subtract_product<arithmetic>(u, across, axis);
  const V push = V(T(4)) * magnitude(inverse(course.t) * (end_a.s + end_b.s));
  const V slide = V(a.mu + b.mu) * push;
  const V kept = kept_by_friction(slide, slide, square_root(dot<arithmetic>(along, along)));
  const Three<V> slid = multiply_add<arithmetic>(half_of * course.t, kept * along - along, m.x1);
  const Three<V> x = select(differ(kept, zero), slid, carried);
  const V shift = half * (touch<V, arithmetic>(b, x).s - touch<V, arithmetic>(a, x).s);
  m.x1 = select(lanes, multiply_add<arithmetic>(shift, axis, x), m.x1);
  m.v1 = select(lanes, multiply_add<arithmetic>(kept, along, v), m.v1);
  return lanes;
}

// Lanes inside `b` that have been put onto another surface before it.
template <class V, Arithmetic arithmetic, PathForm form>
[[gnu::noinline]] Mask<V> pinch_any(const Terms<Scalar<V>>& terms, const Surface<Scalar<V>>& b, V before, Trajectory<V>& m,
                                    const Course<V, arithmetic, form>& course, Mask<V> lanes) noexcept {
  Mask<V> pinched(false);
  for (std::size_t i = 0; i < terms.surface_count; ++i) {
    const Mask<V> is_it = lanes & (before == V(static_cast<Scalar<V>>(i)));
    if (any_lane<V>(is_it)) pinched = pinched | pinch<V, arithmetic, form>(terms.surfaces[i], b, m, course, is_it);
  }
  return pinched;
}

template <class V, Arithmetic arithmetic, PathForm form>
void clamp_all(const Terms<Scalar<V>>& terms, Trajectory<V>& m, Course<V, arithmetic, form>& course, Mask<V> touches) noexcept {
  using T = Scalar<V>;
  watch(terms, course, m.x1, touches);
  V tolerance(T(0));
  V before(T(-1));
  for (int round = 0; round < clamp_rounds; ++round) {
    Mask<V> is_clamped(false);
    for (std::size_t j = 0; j < terms.surface_count; ++j) {
      const auto& surface = terms.surfaces[j];
      const V size = one_norm(m.x1);
      const V number(static_cast<T>(j));
      const Mask<V> is_held = is_among(course.held, number);
      // A plane that holds a lane has it where it should be.
      const Mask<V> is_looked_at = round == 0 && surface.shape == Shape::plane ? touches & !is_held : touches;
      Mask<V> inside = is_looked_at & (touch<V, arithmetic>(surface, m.x1).s < -(tolerance * size));
      if (!any_lane<V>(inside)) continue;
      inside = inside & !leaves<V, arithmetic, form>(surface, course);
      const Mask<V> on_other = inside & (before >= V(T(0))) & differ(before, number);
      if (any_lane<V>(on_other)) {
        const Mask<V> pinched = pinch_any<V, arithmetic, form>(terms, surface, before, m, course, on_other);
        watch(terms, course, m.x1, pinched);
        inside = inside & !pinched;
        touches = touches & !pinched;
      }
      before = select<V>(inside, number, before);
      is_clamped = is_clamped | inside;
      clamp<V, arithmetic, form>(surface, m, course, (course.last == number) | is_held, inside, size);
      watch(terms, course, m.x1, inside);
    }
    touches = touches & is_clamped;
    if (!any_lane<V>(touches)) return;
    tolerance = V(2 * std::numeric_limits<T>::epsilon());
  }
}

template <class T>
bool has_body(const Terms<T>& terms) noexcept {
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    if (terms.surfaces[j].shape != Shape::plane) return true;
  }
  return false;
}

// Whether surfaces may hold lanes at their start. None: it has been looked at.
enum class Standing { unknown, none };

// Only lanes in `touches` change, so that a particle's bits do not depend on its neighbours.
template <class V, Arithmetic arithmetic, PathForm form>
void resolve_all(const Terms<Scalar<V>>& terms, Mask<V> touches, Standing standing, Trajectory<V>& m,
                 Course<V, arithmetic, form>& course) noexcept {
  Leaving<V> leaving;
  if (terms.pushes) push_out<V, arithmetic, form>(terms, m, course, touches, leaving);
  if (standing == Standing::unknown) hold<V, arithmetic, form>(terms, m, course, touches);
  Pressed<V> pressed;
  const bool has_edges = terms.surface_count > 1 && has_pulses(terms.surfaces[0]);
  if (has_edges) pressed = {V(Scalar<V>(-1)), V(Scalar<V>(0)), three<V>(V(Scalar<V>(0)))};
  for (int impact = 0; impact < terms.impacts; ++impact) {
    if (!resolve_earliest<V, arithmetic, form>(terms, m, course, has_edges ? &pressed : nullptr)) break;
  }
  // Lanes near nothing in the end but planes that hold them are outside. (For a body the two tests round in different ways.)
  const Mask<V> lanes = has_body(terms) ? touches : touches & (course.loose | course.active);
  if (any_lane<V>(lanes)) clamp_all<V, arithmetic, form>(terms, m, course, lanes);
}

template <class V, Arithmetic arithmetic>
Course<V, arithmetic, PathForm::parabola> course_of(const Terms<Scalar<V>>& terms, Mask<V> touches) noexcept {
  using T = Scalar<V>;
  return {.direction = V(terms.h < 0 ? T(-1) : T(1)),
          .t = V(terms.h),
          .last = V(T(-1)),
          .active = touches,
          .loose = Mask<V>(false),
          .held = not_held<V>()};
}

// Both return the lanes that have strayed.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Mask<V> resolve_on_parabolas(const Terms<Scalar<V>>& terms, Mask<V> touches, Standing standing,
                                               Trajectory<V>& m) noexcept {
  auto course = course_of<V, arithmetic>(terms, touches);
  resolve_all<V, arithmetic, PathForm::parabola>(terms, touches, standing, m, course);
  return course.strayed;
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Mask<V> resolve_in_flow(const Terms<Scalar<V>>& terms, const Offsets<Scalar<V>>& offsets, Mask<V> touches,
                                          Standing standing, Trajectory<V>& m, const Bending<V, arithmetic>& bending) noexcept {
  using T = Scalar<V>;
  const V one(T(1));
  Course<V, arithmetic, PathForm::flow> course{.direction = V(terms.h < 0 ? T(-1) : T(1)),
                                               .t = V(terms.h),
                                               .last = V(T(-1)),
                                               .active = touches,
                                               .loose = Mask<V>(false),
                                               .held = not_held<V>(),
                                               .bending = &bending,
                                               .h = V(terms.h),
                                               .left = one,
                                               .end = bending(one),
                                               .drive = {}};
  if (bending.is_driven()) {
    course.drive = {three<V>(offsets.drive[0]), three<V>(offsets.drive[1]), three<V>(offsets.drive[2])};
  }
  resolve_all<V, arithmetic, PathForm::flow>(terms, touches, standing, m, course);
  return course.strayed;
}

// The commonest impact straight on: lanes that come from above the only plane, bounce off it once along their parabolas, and do
// not come near it again. The formulas and their order are those of resolve_all. Returns the lanes that are left.
template <class V>
bool is_one_plane(const Terms<Scalar<V>>& terms) noexcept {
  const Surface<Scalar<V>>& surface = terms.surfaces[0];
  return terms.surface_count == 1 && !terms.moves && !terms.searches && terms.bend.degree == 0 && terms.impacts > 1 &&
         surface.shape == Shape::plane && surface.sweep == ContactPath::curve && surface.response == Response::resume &&
         surface.tau == 1;
}

// The record of such bounces for a log: where and how long before the end, what they changed of the velocity, and which of the
// lanes did not just lie there (is_pressed_on of the twin).
template <class V>
struct Bounce {
  Mask<V> bounces, is_impact;
  Three<V> x, dv;
  V t;
};

template <class V, Arithmetic arithmetic>
Mask<V> is_pressed_on(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, V start, V direction, V h) noexcept {
  const Three<V> n = three<V>(surface.n);
  const V near = V(2 * std::numeric_limits<Scalar<V>>::epsilon()) * (one_norm(m.x0) + one_norm(m.x1));
  const V out = direction * dot<arithmetic>(n, m.v0);
  const V press = -(direction * dot<arithmetic>(n, m.v1 - m.v0));
  const Mask<V> is_slow = Mask<V>(has_pulses(surface)) | (out <= V(Scalar<V>(0)));
  return ((start <= near) & is_slow) | hovers<V>(surface, start, out, press, h);
}

// told: null, or what a log is told of.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Mask<V> bounce_once(const Terms<Scalar<V>>& terms, Mask<V> touches, Trajectory<V>& m,
                                      Bounce<V>* told = nullptr) noexcept {
  using T = Scalar<V>;
  const Surface<T>& surface = terms.surfaces[0];
  const V zero(T(0));
  const V one(T(1));
  const V d(surface.d);
  const V direction(terms.h < 0 ? T(-1) : T(1));
  const V h(terms.h);
  const Three<V> n = three<V>(surface.n);
  const V start = dot<arithmetic>(n, m.x0) - d;
  const V near = V(4 * std::numeric_limits<T>::epsilon()) * (one_norm(m.x0) + V(surface.radius));
  const Mask<V> stands = magnitude(start) <= near;
  if (told != nullptr) told->bounces = told->is_impact = Mask<V>(false);
  if (!any_lane<V>(touches & !stands)) return touches;

  const V s0 = select<V>(start < zero, zero, start);
  const V s1 = dot<arithmetic>(n, m.x1) - d;
  const V d0 = h * dot<arithmetic>(n, m.v0);
  const V c = (s1 - s0) - d0;
  const V disc = discriminant<V, arithmetic>(s0, d0, c);
  V f = first_root(s0, d0, c, disc);
  f = select<V>(f < one, f, one);
  Mask<V> hits = s1 < zero;
  if (surface.finds_dips) hits = hits | ((d0 < zero) & (disc > zero) & (-d0 < c + c));

  const Three<V> gain = m.v1 - m.v0;
  const Three<V> xf = along<V, arithmetic>(m.x0, path(surface, m, h), f);
  const Three<V> vf = multiply_add<arithmetic>(f, gain, m.v0);
  const V vn = dot<arithmetic>(n, vf);
  const V rest = one - f;
  const V t = rest * h;
  const V pressed = rest * (direction * dot<arithmetic>(n, gain));
  const Mask<V> is_over = V(surface.e + surface.e) * magnitude(vn) <= V(surface.e - 1) * pressed;
  const V e = surface.e > 0 ? select<V>(is_over, zero, V(surface.e)) : V(surface.e);
  Three<V> vt = subtract_product<arithmetic>(vf, vn, n);
  if (surface.mu != 0) {
    const V slide = V(surface.mu) * ((one + e) * magnitude(vn));
    vt = kept_by_friction(slide, slide, square_root(dot<arithmetic>(vt, vt))) * vt;
  }
  const Three<V> after = subtract_product<arithmetic>(vt, e * vn, n);
  const Three<V> x1 = multiply_add<arithmetic>(t, after - vf, m.x1);
  const Three<V> v1 = multiply_add<arithmetic>(rest, gain, after);

  const Three<V> middle = multiply_add<arithmetic>(V(terms.bend.corner) * t, after, xf);
  const Mask<V> comes_back = (dot<arithmetic>(n, x1) < d) | (dot<arithmetic>(n, middle) < d);
  const Mask<V> bounces = direction * vn <= zero;
  const Mask<V> left = touches & (stands | (hits & (comes_back | !bounces)));
  const Mask<V> done = touches & hits & !left;
  if (told != nullptr) {
    const Three<V> dv = after - vf;
    const Mask<V> may_lie = (e == zero) | Mask<V>(has_pulses(surface));
    const Mask<V> lies = may_lie & is_pressed_on<V, arithmetic>(surface, m, start, direction, h);
    *told = {done, done & is_any_not_zero(dv) & !lies, xf, dv, t};
  }
  m.x1 = select(done, x1, m.x1);
  m.v1 = select(done, v1, m.v1);
  return left;
}

}  // namespace
}  // namespace dvdx
