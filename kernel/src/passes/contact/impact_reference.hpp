// Impacts in the order of time, scalar: written by hand beside impact.inl.hpp.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "passes/contact/rest_reference.hpp"
#include "passes/contact/time_of_impact_reference.hpp"
#include "passes/contact/touch_test_reference.hpp"

namespace dvdx::reference {

// How far off a curved surface the springs of a network may have left what lies on it.
template <Arithmetic arithmetic, class T>
T fallen_away(const Surface<T>& surface, const Particle<T>& p, T t) noexcept {
  return surface.falls_away * (t * t * dot<arithmetic>(p.v0, p.v0));
}

// Whether a particle of a network is as low over a surface, and comes to it as slowly, as what rests there between pulses. out:
// the velocity at which it leaves; press: what other forces than springs give towards the surface until the flow's end.
template <class T>
bool hovers(const Surface<T>& surface, T s, T out, T press, T t) noexcept {
  const T fall = surface.flows_per_substep * press;
  return has_pulses(surface) && s <= T(0.5) * surface.flows_per_substep * fall * std::abs(t) && -out <= fall;
}

// What is left of the tangential velocity at an impact. 1 for what lay or slid on the surface before.
template <Arithmetic arithmetic, PathForm form, class T>
T kept_by_viscosity(const Surface<T>& surface, const Particle<T>& p, const Course<arithmetic, form, T>& course,
                    const Vector<T>& gain, bool is_over) noexcept {
  if (surface.tau == 1) return 1;
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const Touch<T> start = touch<arithmetic>(surface, p.x0);
  const T low = low_bounce * eps * (one_norm(p.x0) + surface.radius);
  const T out = course.direction * dot<arithmetic>(start.n, p.v0);
  const T press = -(course.direction * dot<arithmetic>(start.n, gain));
  const T own = std::abs(press);
  const T rounding = 4 * eps * one_norm(p.v0);
  const bool stays_low = out <= rounding || out * out * std::abs(course.t) <= 2 * own * low;
  const bool comes_slow = -out <= own + rounding;
  const bool is_slow = has_pulses(surface) || (out > 0 ? stays_low : comes_slow);
  const bool lies = start.s <= 4 * low + fallen_away<arithmetic>(surface, p, course.t) && is_slow;
  const bool rests = lies || hovers(surface, start.s, out, press, course.t);
  return rests ? T(1) : is_over ? T(0) : surface.tau;
}

template <class T>
struct Moment {
  Vector<T> x, v;
};

template <Arithmetic arithmetic, PathForm form, class T>
Moment<T> moment(const Surface<T>& surface, const Particle<T>& p, const Course<arithmetic, form, T>& course,
                 const Vector<T>& gain, T f) noexcept {
  Moment<T> at;
  if constexpr (form == PathForm::parabola) {
    at.x = along<arithmetic>(p.x0, path(surface, p, course.t), f);
    for (std::size_t k = 0; k < 3; ++k) at.v[k] = multiply_add<arithmetic>(f, gain[k], p.v0[k]);
    return at;
  } else {
    const Responses<T> P = (*course.bending)(f * course.left);
    const auto& end = course.end;
    const bool is_driven = course.bending->is_driven();
    const T frequency = 1 / course.h;
    const Vector<T> drive_end = driven<arithmetic>(course.drive, end.P2, end.P3, end.P4);
    const Vector<T> drive_here = driven<arithmetic>(course.drive, P.P2, P.P3, P.P4);
    for (std::size_t k = 0; k < 3; ++k) {
      const T v1 = is_driven ? p.v1[k] - frequency * drive_end[k] : p.v1[k];
      const T pull = subtract_product<arithmetic>(v1, p.v0[k], end.P0[k]) * inverse(end.P1[k]);
      at.v[k] = multiply_add<arithmetic>(pull, P.P1[k], p.v0[k] * P.P0[k]);
      if (is_driven) at.v[k] = at.v[k] + frequency * drive_here[k];
    }
    if (surface.sweep == ContactPath::line) {
      at.x = along<arithmetic>(p.x0, path(surface, p, course.t), f);
      return at;
    }
    const Vector<T> way = flow_path(p, course).way(P);
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

// Whether a particle lies on a surface that it is pressed onto from here on. Of a sheet that rests, each pulse of its springs
// presses, or lifts it so little that it is back within the sub-step.
template <Arithmetic arithmetic, PathForm form, class T>
bool is_pressed_on(const Surface<T>& surface, const Particle<T>& p, const Course<arithmetic, form, T>& course) noexcept {
  const Particle<T> seen = seen_from<arithmetic>(surface, p, course.t);
  const Touch<T> start = touch<arithmetic>(surface, seen.x0);
  const T sizes = (one_norm(seen.x0) + one_norm(p.x1)) + (surface.radius + surface.radius);
  const T roundings = surface.movement == Movement::rest ? 2 : 8;
  const T near = roundings * std::numeric_limits<T>::epsilon() * sizes + fallen_away<arithmetic>(surface, seen, course.t);
  const T out = course.direction * dot<arithmetic>(start.n, seen.v0);
  const T press = -(course.direction * dot<arithmetic>(start.n, difference(p.v1, p.v0)));
  return (start.s <= near && (has_pulses(surface) || out <= 0)) || hovers(surface, start.s, out, press, course.t);
}

template <Arithmetic arithmetic, PathForm form, class T>
void respond(const Surface<T>& surface, Particle<T>& p, Course<arithmetic, form, T>& course, T f) noexcept {
  const bool lies = course.recording != nullptr && is_pressed_on(surface, p, course);
  if (course.recording != nullptr) course.recording->let_go(f);
  const Vector<T> gain = difference(p.v1, p.v0);
  const auto [xf, vf] = moment(surface, p, course, gain, f);
  const T rest = 1 - f;
  const auto [n, V] = meeting<arithmetic>(surface, xf, rest * course.t);
  const bool moves = surface.movement != Movement::rest;
  const Vector<T> vr = moves ? difference(vf, V) : vf;
  const T vn = dot<arithmetic>(n, vr);
  const Vector<T> forces = course.held.a != Held<T>::none ? difference(gain, course.held.dv) : gain;
  const T pressed = rest * (course.direction * dot<arithmetic>(n, forces));
  const bool is_over = surface.response == Response::resume && surface.e > 0 &&
                       (surface.e + surface.e) * std::abs(vn) <= (surface.e - 1) * pressed;
  const T e = is_over ? T(0) : surface.e;
  const T tau = kept_by_viscosity(surface, seen_from<arithmetic>(surface, p, course.t), course, gain, is_over);
  course.t = rest * course.t;
  if constexpr (form == PathForm::flow) {
    const T passed = f * course.left;
    const T half = T(0.5) * passed;
    auto& [D1, D2, D3] = course.drive;
    for (std::size_t k = 0; k < 3 && course.bending->is_driven(); ++k) {
      D1[k] = multiply_add<arithmetic>(passed, multiply_add<arithmetic>(half, D3[k], D2[k]), D1[k]);
      D2[k] = multiply_add<arithmetic>(passed, D3[k], D2[k]);
    }
    course.left = rest * course.left;
    course.end = (*course.bending)(course.left);
  }
  p.x0 = xf;
  p.v0 = vf;
  const auto let_go = [&] {
    if (course.held.a == Held<T>::none) return;
    for (std::size_t k = 0; k < 3; ++k) p.v1[k] = subtract_product<arithmetic>(p.v1[k], rest, course.held.dv[k]);
  };
  if (course.held.a != Held<T>::none) {
    for (std::size_t k = 0; k < 3; ++k) p.x1[k] = subtract_product<arithmetic>(p.x1[k], rest * rest, course.held.dx[k]);
  }
  if (!(course.direction * vn <= 0)) return let_go();

  Vector<T> vt;
  for (std::size_t k = 0; k < 3; ++k) vt[k] = tau * subtract_product<arithmetic>(vr[k], vn, n[k]);
  const T slide = surface.mu * ((1 + e) * std::abs(vn));
  const T kept = kept_by_friction(slide, slide, std::sqrt(dot<arithmetic>(vt, vt)));
  Vector<T> way = difference(p.x1, xf);
  for (std::size_t k = 0; k < 3 && moves; ++k) way[k] = subtract_product<arithmetic>(way[k], course.t, V[k]);
  const T beyond = dot<arithmetic>(n, way);
  for (std::size_t k = 0; k < 3; ++k) {
    T after = subtract_product<arithmetic>(kept * vt[k], e * vn, n[k]);
    if (moves) after = after + V[k];
    const T pulse = after - vf[k];
    if (surface.response == Response::end_on_surface) {
      p.x1[k] = subtract_product<arithmetic>(p.x1[k], beyond, n[k]);
    } else if (form == PathForm::parabola) {
      p.x1[k] = multiply_add<arithmetic>(course.t, pulse, p.x1[k]);
    } else {
      p.x1[k] = multiply_add<arithmetic>(course.h * course.end.P1[k], pulse, p.x1[k]);
    }
    p.v1[k] = form == PathForm::parabola ? multiply_add<arithmetic>(rest, gain[k], after)
                                         : multiply_add<arithmetic>(course.end.P0[k], pulse, p.v1[k]);
    p.v0[k] = after;
  }
  if (course.recording != nullptr) {
    const Vector<T> dv = difference(p.v0, vf);
    const bool hits = dv != Vector<T>{} && !(lies && (e == 0 || has_pulses(surface)));
    course.recording->push(hits ? Told::impact : Told::hold, course.last, xf, n, dv, course.t);
  }
  let_go();
}

template <Arithmetic arithmetic, PathForm form, class T>
std::optional<T> cross(const Terms<T>& terms, const Surface<T>& surface, const Particle<T>& p,
                       const Course<arithmetic, form, T>& course, bool is_held, T low) noexcept {
  const Particle<T> seen = seen_from<arithmetic>(surface, p, course.t);
  switch (surface.shape) {
    case Shape::plane:
      return cross_plane(terms, surface, seen, p, course, is_held, low);
    case Shape::sphere:
      return cross_sphere(terms, surface, seen, p, course, is_held, low);
    case Shape::capsule:
    case Shape::box:
    case Shape::convex:
    case Shape::mesh:
      break;
  }
  return cross_solid(surface, seen, p, course, is_held, low);
}

// Whether there was an impact.
template <Arithmetic arithmetic, PathForm form, class T>
bool resolve_earliest(const Terms<T>& terms, Particle<T>& p, Course<arithmetic, form, T>& course) noexcept {
  const T low = 4 * low_bounce * std::numeric_limits<T>::epsilon() * one_norm(p.x0);
  const T corner = terms.bend.corner * course.t;
  Vector<T> middle;
  for (std::size_t k = 0; k < 3; ++k) middle[k] = multiply_add<arithmetic>(corner, p.v0[k], p.x0[k]);
  T earliest = 2;
  std::size_t which = terms.surface_count;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    if (course.held.has(j) || !may_touch_moving<arithmetic>(surface, p, middle, course.t, corner)) continue;
    const std::optional<T> f = cross(terms, surface, p, course, course.last == j, low);
    if (f && *f < earliest) {
      earliest = *f;
      which = j;
    }
  }
  if (which == terms.surface_count) return false;
  course.last = which;
  respond(terms.surfaces[which], p, course, earliest);
  hold(terms, p, course);
  return true;
}

template <Arithmetic arithmetic, PathForm form, class T>
void clamp(const Surface<T>& surface, Particle<T>& p, const Course<arithmetic, form, T>& course, bool is_held,
           T size) noexcept {
  const Vector<T> n = touch<arithmetic>(surface, p.x1).n;
  Particle<T> seen = seen_from<arithmetic>(surface, p, course.t);
  const T vn = dot<arithmetic>(n, seen.v1);
  if (course.direction * vn < 0) {
    const T removed = std::abs(vn);
    Vector<T> vt;
    for (std::size_t k = 0; k < 3; ++k) vt[k] = subtract_product<arithmetic>(seen.v1[k], vn, n[k]);
    const T kept = kept_by_friction(surface.mu * removed, surface.hold * removed, std::sqrt(dot<arithmetic>(vt, vt)));
    for (std::size_t k = 0; k < 3; ++k) seen.v1[k] = kept * vt[k];
    if (surface.movement == Movement::rest) p.v1 = seen.v1;
  }
  const Vector<T> sum = sum_of(seen.v0, seen.v1);
  const T motion = std::abs(course.t) * one_norm(sum);
  const bool rests = is_held && motion < std::numeric_limits<T>::epsilon() / 4 * size;
  const Vector<T> base = rests ? seen.x0 : p.x1;
  const Touch<T> there = touch<arithmetic>(surface, base);
  for (std::size_t k = 0; k < 3; ++k) p.x1[k] = subtract_product<arithmetic>(base[k], there.s, there.n[k]);
  if (surface.movement == Movement::rest || !(course.direction * vn < 0)) return;
  p.v1 = sum_of(seen.v1, velocity_at<arithmetic>(surface, p.x1, T(0)));
}

template <Arithmetic arithmetic, PathForm form, class T>
void resolve_all(const Terms<T>& terms, Particle<T>& p, Course<arithmetic, form, T>& course) noexcept {
  hold(terms, p, course);
  for (int impact = 0; impact < terms.impacts; ++impact) {
    if (!resolve_earliest(terms, p, course)) break;
  }
  if (course.recording != nullptr) course.recording->let_go(1);
  T tolerance = 0;
  for (int round = 0; round < clamp_rounds; ++round) {
    bool is_clamped = false;
    for (std::size_t j = 0; j < terms.surface_count; ++j) {
      const T size = one_norm(p.x1);
      const bool is_held = course.held.has(j);
      if (round == 0 && is_held && terms.surfaces[j].shape == Shape::plane) continue;
      if (!(touch<arithmetic>(terms.surfaces[j], p.x1).s < -(tolerance * size))) continue;
      is_clamped = true;
      const Vector<T> before = p.v1;
      clamp(terms.surfaces[j], p, course, course.last == j || is_held, size);
      if (course.recording != nullptr) course.recording->push(Told::hold, j, p.x1, {}, difference(p.v1, before), T(0));
    }
    if (!is_clamped) return;
    tolerance = 2 * std::numeric_limits<T>::epsilon();
  }
}

}  // namespace dvdx::reference
