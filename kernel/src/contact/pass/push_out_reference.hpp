// Leads particles out of surfaces inside which they start, scalar: written by hand beside push_out.inl.hpp.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

#include "contact/pass/rest_reference.hpp"

namespace dvdx::reference {

// The start of a path as the surface sees it. is_inside: deeper than rounding; is_free: further out than rounding.
template <class T>
struct Start {
  Touch<T> at;
  bool is_inside, is_free;
};

template <Arithmetic arithmetic, class T>
Start<T> start_on(const Surface<T>& surface, const Vector<T>& x, T t) noexcept {
  const Vector<T> there = surface.movement == Movement::rest ? x : taken_along<arithmetic>(surface, x, t);
  const Touch<T> at = touch<arithmetic>(surface, there);
  const T rounding = least_depth * std::numeric_limits<T>::epsilon() * (one_norm(there) + surface.radius);
  return {at, (at.s < -rounding), (at.s > rounding)};
}

template <Arithmetic arithmetic, PathForm form, class T>
bool leaves(const Surface<T>& surface, const ImpactState<arithmetic, form, T>& state) noexcept {
  if (state.leaving == nullptr || !pushes_out(surface)) return false;
  return start_on<arithmetic>(surface, state.leaving->x0, state.leaving->t).is_inside;
}

template <class T>
T within(T x, T least, T most) noexcept {
  if (x < least) return least;
  return x > most ? most : x;
}

template <Arithmetic arithmetic, PathForm form, class T>
void leave(const Surface<T>& surface, Particle<T>& p, const ImpactState<arithmetic, form, T>& state) noexcept {
  const bool moves = surface.movement != Movement::rest;
  const Particle<T> seen = seen_from<arithmetic>(surface, p, state.t);
  const Touch<T> start = touch<arithmetic>(surface, seen.x0);
  const T way = state.t * surface.push_out;
  const T most = start.s + way;
  const bool stays_inside = most < 0;
  const T least = stays_inside ? most : T(0);

  const T vn0 = dot<arithmetic>(start.n, seen.v0);
  const T slower = within(vn0, T(0), surface.push_out) - vn0;
  const bool turns = surface.movement == Movement::turns;
  const Vector<T> n0 = turns ? turned_by<arithmetic>(scaled_by(-state.t, surface.omega), start.n) : start.n;
  const T gone = dot<arithmetic>(start.n, difference(p.x1, seen.x0));
  const T further = within(gone, stays_inside ? way : -start.s, way) - gone;
  for (std::size_t k = 0; k < 3; ++k) {
    p.v0[k] = multiply_add<arithmetic>(slower, n0[k], p.v0[k]);
    p.v1[k] = multiply_add<arithmetic>(slower, n0[k], p.v1[k]);
    p.x1[k] = multiply_add<arithmetic>(further, start.n[k], p.x1[k]);
  }

  const Touch<T> end = touch<arithmetic>(surface, p.x1);
  const T onto = within(end.s, least, most) - end.s;
  const Vector<T> V = moves ? velocity_at<arithmetic>(surface, p.x1, T(0)) : Vector<T>{};
  const Vector<T> u = moves ? difference(p.v1, V) : p.v1;
  const T vn = dot<arithmetic>(end.n, u);
  const T out = within(vn, T(0), surface.push_out);
  const T removed = (slower > 0 ? slower : T(0)) + (vn < 0 ? -vn : T(0));
  Vector<T> vt;
  for (std::size_t k = 0; k < 3; ++k) vt[k] = subtract_product<arithmetic>(u[k], vn, end.n[k]);
  const T kept = kept_by_friction(surface.mu * removed, surface.hold * removed, std::sqrt(dot<arithmetic>(vt, vt)));
  for (std::size_t k = 0; k < 3; ++k) {
    const T v = multiply_add<arithmetic>(out, end.n[k], kept * vt[k]);
    p.v1[k] = moves ? v + V[k] : v;
    p.x1[k] = multiply_add<arithmetic>(onto, end.n[k], p.x1[k]);
  }
}

// Whether two surfaces face each other, so that friction jams a particle between them. kappa: the product of their normals.
template <class T>
bool face_each_other(T mu_a, T mu_b, T kappa) noexcept {
  const T mu = mu_a < mu_b ? mu_a : mu_b;
  const T grip = mu > least_grip<T> ? mu : least_grip<T>;
  const T opening = 1 - kappa;
  return 1 + kappa <= grip * grip * opening;
}

// Whether a particle starts inside a surface that pushes out, and not between two surfaces that face each other.
template <Arithmetic arithmetic, PathForm form, class T>
bool starts_to_leave(const Terms<T>& terms, const Particle<T>& p, const ImpactState<arithmetic, form, T>& state) noexcept {
  std::size_t deepest = terms.surface_count;
  Touch<T> a{.n = {}, .s = 0};
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    if (!pushes_out(terms.surfaces[j])) continue;
    const Start<T> start = start_on<arithmetic>(terms.surfaces[j], p.x0, state.t);
    if (!start.is_inside || !(start.at.s < a.s)) continue;
    deepest = j;
    a = start.at;
  }
  if (deepest == terms.surface_count) return false;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const Start<T> start = start_on<arithmetic>(surface, p.x0, state.t);
    if (j == deepest || start.is_free) continue;
    if (face_each_other(terms.surfaces[deepest].mu, surface.mu, dot<arithmetic>(a.n, start.at.n))) return false;
  }
  return true;
}

// Brings a particle out of the surfaces that it leaves, each along its own normal. Returns whether it leaves any.
template <Arithmetic arithmetic, PathForm form, class T>
bool push_out(const Terms<T>& terms, Particle<T>& p, ImpactState<arithmetic, form, T>& state, Leaving<T>& leaving) noexcept {
  if (!starts_to_leave(terms, p, state)) return false;
  leaving = {p.x0, state.t};
  state.leaving = &leaving;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    if (!leaves(terms.surfaces[j], state)) continue;
    const Vector<T> v = p.v1;
    leave(terms.surfaces[j], p, state);
    if (state.recording != nullptr) state.recording->push(EventKind::hold, j, p.x1, {}, difference(p.v1, v), T(0));
  }
  return true;
}

}  // namespace dvdx::reference
