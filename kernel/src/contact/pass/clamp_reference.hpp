// Puts a particle whose step ends inside a surface onto it, or between two surfaces that leave no room, scalar: written by hand
// beside clamp.inl.hpp.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

#include "contact/pass/push_out_reference.hpp"
#include "contact/pass/rest_reference.hpp"
#include "contact/pass/touch_test_reference.hpp"

namespace dvdx::reference {

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

}  // namespace dvdx::reference
