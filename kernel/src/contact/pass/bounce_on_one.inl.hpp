// A fast path for the most common impact, wide: lanes that come from above the only plane, bounce off it once along parabolas,
// and do not come near it again. Formulas and their order are those of resolve_all (impact.inl.hpp).
#pragma once

#include <cstddef>
#include <limits>

#include "contact/pass/respond.inl.hpp"

namespace dvdx {
namespace {

// Whether a scene's only surface is such a plane.
template <class V>
bool is_one_plane(const Terms<Scalar<V>>& terms) noexcept {
  const Surface<Scalar<V>>& surface = terms.surfaces[0];
  return terms.surface_count == 1 && !terms.moves && !terms.searches && terms.bend.degree == 0 && terms.impacts > 1 &&
         surface.shape == Shape::plane && surface.sweep == ContactPath::curve && surface.response == Response::resume &&
         surface.tau == 1;
}

// Bounces for a log: the place x, the change dv of the velocity, the time t before the end. is_impact: lanes that did not just
// lie on the plane (is_pressed_on of the twin).
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

// Bounces lanes and returns those that are left to resolve. told: null, or receives the bounces for a log.
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
