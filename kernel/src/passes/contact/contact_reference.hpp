// The contact pass, scalar: written by hand beside contact.inl.hpp, the same letters in the same order of operations.
// Derivations and sources stand in contact.hpp.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "passes/contact/contact.hpp"
#include "passes/particle.hpp"
#include "passes/terms.hpp"

namespace dvdx::reference {

template <class T>
using Vector = std::array<T, 3>;

template <Arithmetic arithmetic, class T>
T dot(const Vector<T>& a, const Vector<T>& b) noexcept {
  return multiply_add<arithmetic>(a[2], b[2], multiply_add<arithmetic>(a[1], b[1], a[0] * b[0]));
}

template <class T>
Vector<T> difference(const Vector<T>& a, const Vector<T>& b) noexcept {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

template <class T>
T one_norm(const Vector<T>& a) noexcept {
  return (std::abs(a[0]) + std::abs(a[1])) + std::abs(a[2]);
}

// ---------------------------------------------------------------------------------- does anything happen at all

template <Arithmetic arithmetic, class T>
bool may_touch_plane(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle) noexcept {
  if (dot<arithmetic>(surface.n, p.x1) < surface.d) return true;
  return surface.finds_dips && dot<arithmetic>(surface.n, middle) < surface.d;
}

template <Arithmetic arithmetic, class T>
bool may_touch_sphere(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle) noexcept {
  const Vector<T> r0 = difference(p.x0, surface.center);
  const Vector<T> r1 = difference(p.x1, surface.center);
  const Vector<T> rm = difference(middle, surface.center);
  const T square = surface.radius * surface.radius;
  if (surface.side < 0) {
    if (dot<arithmetic>(r1, r1) > square) return true;
    return surface.finds_dips && dot<arithmetic>(rm, rm) > square;
  }
  const T reach = square * dot<arithmetic>(r0, r0);
  const auto is_near = [&](const Vector<T>& r) {
    const T along = dot<arithmetic>(r0, r);
    return along <= 0 || along * along <= reach;
  };
  return is_near(r1) || (surface.finds_dips && is_near(rm));
}

template <Arithmetic arithmetic, class T>
bool may_touch(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle) noexcept {
  switch (surface.shape) {
    case Shape::plane:
      return may_touch_plane<arithmetic>(surface, p, middle);
    case Shape::sphere:
      break;
  }
  return may_touch_sphere<arithmetic>(surface, p, middle);
}

template <Arithmetic arithmetic, class T>
bool may_touch(const Terms<T>& terms, const Particle<T>& p) noexcept {
  const T half = terms.h * T(0.5);
  Vector<T> middle;
  for (std::size_t k = 0; k < 3; ++k) middle[k] = multiply_add<arithmetic>(half, p.v0[k], p.x0[k]);
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    if (may_touch<arithmetic>(terms.surfaces[j], p, middle)) return true;
  }
  return false;
}

// ---------------------------------------------------------------------------------- geometry

template <class T>
struct Touch {
  Vector<T> n{};
  T s = 0;
};

template <Arithmetic arithmetic, class T>
Touch<T> touch_sphere(const Surface<T>& surface, const Vector<T>& x) noexcept {
  const Vector<T> r = difference(x, surface.center);
  const T length = std::sqrt(dot<arithmetic>(r, r));
  const T s = surface.side * (length - surface.radius);
  if (length > 0) {
    const T scale = surface.side / length;
    return {{scale * r[0], scale * r[1], scale * r[2]}, s};
  }
  return {{surface.side * r[0], surface.side, surface.side * r[2]}, s};
}

template <Arithmetic arithmetic, class T>
Touch<T> touch(const Surface<T>& surface, const Vector<T>& x) noexcept {
  switch (surface.shape) {
    case Shape::plane:
      return {surface.n, dot<arithmetic>(surface.n, x) - surface.d};
    case Shape::sphere:
      break;
  }
  return touch_sphere<arithmetic>(surface, x);
}

template <class T>
struct Path {
  Vector<T> u{}, a{};
};

template <class T>
Path<T> path(const Surface<T>& surface, const Particle<T>& p, T t) noexcept {
  const Vector<T> chord = difference(p.x1, p.x0);
  if (goes_straight(surface)) return {chord, {}};
  Path<T> path;
  for (std::size_t k = 0; k < 3; ++k) {
    path.u[k] = t * p.v0[k];
    path.a[k] = chord[k] - path.u[k];
  }
  return path;
}

template <Arithmetic arithmetic, class T>
Vector<T> along(const Vector<T>& start, const Path<T>& path, T f) noexcept {
  Vector<T> x;
  for (std::size_t k = 0; k < 3; ++k) {
    x[k] = multiply_add<arithmetic>(f, multiply_add<arithmetic>(f, path.a[k], path.u[k]), start[k]);
  }
  return x;
}

// ---------------------------------------------------------------------------------- time of impact

template <Arithmetic arithmetic, class T>
T discriminant(T s0, T d0, T c) noexcept {
  return subtract_product<arithmetic>(d0 * d0, 4 * c, s0);
}

template <class T>
T first_root(T s0, T d0, T c, T disc) noexcept {
  const T root = disc > 0 ? std::sqrt(disc) : T(0);
  if (d0 < 0) return (s0 + s0) / (root - d0);
  return (d0 + (s0 > 0 ? root : d0)) / (-2 * c);
}

template <Arithmetic arithmetic, class T>
std::optional<T> cross_plane(const Surface<T>& surface, const Particle<T>& p, T t, bool is_held, T low) noexcept {
  T s0 = touch<arithmetic>(surface, p.x0).s;
  if (is_held || s0 < 0) s0 = 0;
  const T s1 = touch<arithmetic>(surface, p.x1).s;
  const T d0 = surface.sweep == ContactPath::line ? s1 - s0 : t * dot<arithmetic>(surface.n, p.v0);
  const T c = (s1 - s0) - d0;
  const T disc = discriminant<arithmetic>(s0, d0, c);
  const bool dips = surface.finds_dips && d0 < 0 && disc > 0 && -d0 < c + c;
  if (!(s1 < 0 || dips)) return std::nullopt;
  if (is_held && (surface.response == Response::end_on_surface || d0 <= 0 || d0 * d0 <= -(low * c))) return std::nullopt;
  const T f = first_root(s0, d0, c, disc);
  return f < 1 ? f : T(1);
}

template <Arithmetic arithmetic, class T>
std::optional<T> cross_sphere(const Surface<T>& surface, const Particle<T>& p, T t, bool is_held, T low) noexcept {
  const T k = surface.half_curvature;
  const T square = surface.radius * surface.radius;
  const Path<T> way = path(surface, p, t);
  const Vector<T> r0 = difference(p.x0, surface.center);
  const Vector<T> r1 = difference(p.x1, surface.center);

  T g0 = k * (dot<arithmetic>(r0, r0) - square);
  if (is_held || g0 < 0) g0 = 0;
  const T g1 = k * (dot<arithmetic>(r1, r1) - square);
  const T d0 = (k + k) * dot<arithmetic>(r0, way.u);
  const T across = dot<arithmetic>(r0, way.a);
  const T b = k * (dot<arithmetic>(way.u, way.u) + (across + across));
  const T c = (g1 - g0) - d0;
  if (is_held && (surface.response == Response::end_on_surface || d0 <= 0 || d0 * d0 <= -(low * c))) return std::nullopt;

  const T disc = discriminant<arithmetic>(g0, d0, b);
  T f = first_root(g0, d0, b, disc);
  const bool found = disc >= 0 && (d0 < 0 || b < 0) && f <= 1;
  if (!found) f = first_root(g0, d0, c, discriminant<arithmetic>(g0, d0, c));
  if (!(f < 1)) f = 1;

  T g = 0;
  T slope = 0;
  for (int step = 0;; ++step) {
    const Vector<T> r = along<arithmetic>(r0, way, f);
    Vector<T> tangent;
    for (std::size_t axis = 0; axis < 3; ++axis) tangent[axis] = multiply_add<arithmetic>(f + f, way.a[axis], way.u[axis]);
    g = k * (dot<arithmetic>(r, r) - square);
    slope = (k + k) * dot<arithmetic>(r, tangent);
    if (step == newton_steps) break;
    const T next = f - g / slope;
    if (slope < 0 && next >= 0 && next <= 1) f = next;
  }
  const T scale = (one_norm(r0) + one_norm(way.u)) + surface.radius;
  const bool dips = found && slope < 0 && g <= 16 * std::numeric_limits<T>::epsilon() * scale;
  if (!(g1 < 0 || dips)) return std::nullopt;
  return f;
}

// ---------------------------------------------------------------------------------- impacts and resting

template <class T>
T kept_by_friction(T slide, T hold, T length) noexcept {
  if (!(hold > 0)) return 1;
  if (hold >= length) return 0;
  return 1 - slide / length;
}

// What is left of a particle's step.
template <class T>
struct Course {
  T direction, t;
  std::size_t last;  // the surface hit last, or the count of surfaces
};

// What is left of the tangential velocity at an impact. What lay or slid on the surface before comes to none.
template <Arithmetic arithmetic, class T>
T kept_by_viscosity(const Surface<T>& surface, const Particle<T>& p, const Course<T>& course, const Vector<T>& gain) noexcept {
  if (surface.tau == 1) return 1;
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const Touch<T> start = touch<arithmetic>(surface, p.x0);
  const T low = low_bounce * eps * (one_norm(p.x0) + surface.radius);
  const T out = course.direction * dot<arithmetic>(start.n, p.v0);
  const T own = std::abs(dot<arithmetic>(start.n, gain));
  const T rounding = 4 * eps * one_norm(p.v0);
  const bool stays_low = out <= rounding || out * out * std::abs(course.t) <= 2 * own * low;
  const bool comes_slow = -out <= own + rounding;
  const bool rests = start.s <= 4 * low && (out > 0 ? stays_low : comes_slow);
  return rests ? T(1) : surface.tau;
}

template <Arithmetic arithmetic, class T>
void respond(const Surface<T>& surface, Particle<T>& p, Course<T>& course, T f) noexcept {
  const Vector<T> xf = along<arithmetic>(p.x0, path(surface, p, course.t), f);
  const Vector<T> gain = difference(p.v1, p.v0);
  Vector<T> vf;
  for (std::size_t k = 0; k < 3; ++k) vf[k] = multiply_add<arithmetic>(f, gain[k], p.v0[k]);
  const Vector<T> n = touch<arithmetic>(surface, xf).n;
  const T vn = dot<arithmetic>(n, vf);
  const T tau = kept_by_viscosity<arithmetic>(surface, p, course, gain);
  const T rest = 1 - f;
  course.t = rest * course.t;
  p.x0 = xf;
  p.v0 = vf;
  if (!(course.direction * vn <= 0)) return;

  Vector<T> vt;
  for (std::size_t k = 0; k < 3; ++k) vt[k] = tau * subtract_product<arithmetic>(vf[k], vn, n[k]);
  const T slide = surface.mu * ((1 + surface.e) * std::abs(vn));
  const T kept = kept_by_friction(slide, slide, std::sqrt(dot<arithmetic>(vt, vt)));
  const T beyond = dot<arithmetic>(n, difference(p.x1, xf));
  for (std::size_t k = 0; k < 3; ++k) {
    const T after = subtract_product<arithmetic>(kept * vt[k], surface.e * vn, n[k]);
    p.x1[k] = surface.response == Response::end_on_surface ? subtract_product<arithmetic>(p.x1[k], beyond, n[k])
                                                           : multiply_add<arithmetic>(course.t, after - vf[k], p.x1[k]);
    p.v1[k] = multiply_add<arithmetic>(rest, gain[k], after);
    p.v0[k] = after;
  }
}

template <Arithmetic arithmetic, class T>
std::optional<T> cross(const Surface<T>& surface, const Particle<T>& p, T t, bool is_held, T low) noexcept {
  switch (surface.shape) {
    case Shape::plane:
      return cross_plane<arithmetic>(surface, p, t, is_held, low);
    case Shape::sphere:
      break;
  }
  return cross_sphere<arithmetic>(surface, p, t, is_held, low);
}

// Whether there was an impact.
template <Arithmetic arithmetic, class T>
bool resolve_earliest(const Terms<T>& terms, Particle<T>& p, Course<T>& course) noexcept {
  const T low = 4 * low_bounce * std::numeric_limits<T>::epsilon() * one_norm(p.x0);
  T earliest = 2;
  std::size_t which = terms.surface_count;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const std::optional<T> f = cross<arithmetic>(terms.surfaces[j], p, course.t, course.last == j, low);
    if (f && *f < earliest) {
      earliest = *f;
      which = j;
    }
  }
  if (which == terms.surface_count) return false;
  course.last = which;
  respond<arithmetic>(terms.surfaces[which], p, course, earliest);
  return true;
}

template <Arithmetic arithmetic, class T>
void clamp(const Surface<T>& surface, Particle<T>& p, const Course<T>& course, bool is_held, T size) noexcept {
  const Vector<T> n = touch<arithmetic>(surface, p.x1).n;
  const T vn = dot<arithmetic>(n, p.v1);
  if (course.direction * vn < 0) {
    const T removed = std::abs(vn);
    Vector<T> vt;
    for (std::size_t k = 0; k < 3; ++k) vt[k] = subtract_product<arithmetic>(p.v1[k], vn, n[k]);
    const T kept = kept_by_friction(surface.mu * removed, surface.hold * removed, std::sqrt(dot<arithmetic>(vt, vt)));
    for (std::size_t k = 0; k < 3; ++k) p.v1[k] = kept * vt[k];
  }
  const Vector<T> sum = {p.v0[0] + p.v1[0], p.v0[1] + p.v1[1], p.v0[2] + p.v1[2]};
  const T motion = std::abs(course.t) * one_norm(sum);
  const bool rests = is_held && motion < std::numeric_limits<T>::epsilon() / 4 * size;
  const Vector<T> base = rests ? p.x0 : p.x1;
  const Touch<T> there = touch<arithmetic>(surface, base);
  for (std::size_t k = 0; k < 3; ++k) p.x1[k] = subtract_product<arithmetic>(base[k], there.s, there.n[k]);
}

template <Arithmetic arithmetic, class T>
void resolve_contacts(const Terms<T>& terms, Particle<T>& p) noexcept {
  if (!may_touch<arithmetic>(terms, p)) return;
  Course<T> course{terms.h < 0 ? T(-1) : T(1), terms.h, terms.surface_count};
  for (int impact = 0; impact < terms.impacts; ++impact) {
    if (!resolve_earliest<arithmetic>(terms, p, course)) break;
  }
  T tolerance = 0;
  for (int round = 0; round < clamp_rounds; ++round) {
    bool is_clamped = false;
    for (std::size_t j = 0; j < terms.surface_count; ++j) {
      const T size = one_norm(p.x1);
      if (!(touch<arithmetic>(terms.surfaces[j], p.x1).s < -(tolerance * size))) continue;
      is_clamped = true;
      clamp<arithmetic>(terms.surfaces[j], p, course, course.last == j, size);
    }
    if (!is_clamped) return;
    tolerance = 2 * std::numeric_limits<T>::epsilon();
  }
}

}  // namespace dvdx::reference
