// A fast path for the most common rest: lanes that one plane at rest holds, and that come near no other. Formulas and their
// order are those of hold() and Nearness; the scalar twin is rest_reference.hpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "contact/pass/rest.inl.hpp"
#include "contact/surfaces/surface.hpp"
#include "flow/terms.hpp"

namespace dvdx {
namespace {

// Lanes that touch a plane and are left as they were. pressed: by one plane onto another, which may hold them too; busy: they
// may meet a plane; is_any_held: whether a plane holds a busy lane at the start of the step.
struct NotAtRest {
  std::uint64_t pressed, busy;  // lane k is bit k
  bool is_any_held;
};

// The plane that may hold lanes.
template <class V>
struct Floor {
  V number, s, s0, mu, hold;
  Three<V> n;
};

// Tests planes independently, without a branch on which plane holds lanes: that differs from register to register.
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Floor<V> floor_of(const Terms<Scalar<V>>& terms, std::size_t count, const Trajectory<V>& m,
                                                V size, V end_size) noexcept {
  using T = Scalar<V>;
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const V zero(T(0));
  const V h(terms.h);
  const V low = V(4 * low_bounce * eps) * size;
  const V near = V(2 * eps) * (size + end_size);
  const V sunk = V(T(-0.5)) * near;
  Floor<V> a{V(T(-1)), zero, zero, zero, zero, three<V>(zero)};
  for (std::size_t j = 0; j < count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const Three<V> n = three<V>(surface.n);
    const V s = dot<arithmetic>(n, m.x1) - V(surface.d);
    const V s0 = dot<arithmetic>(n, m.x0) - V(surface.d);
    const V d0 = h * dot<arithmetic>(n, m.v0);
    const V c = s - d0;
    const Mask<V> comes_slow = (-d0 <= -(c + c)) & (V(surface.e) * -d0 <= V(T(1) - surface.e) * -c);
    const Mask<V> stays = ((d0 > zero) & (d0 * d0 <= -(low * c))) | ((d0 <= zero) & comes_slow);
    const V depth = select<V>(stays & (s0 >= sunk) & (s0 <= near), s, zero);
    const Mask<V> is_it = depth < a.s;
    a.number = select<V>(is_it, V(static_cast<T>(j)), a.number);
    a.s = select<V>(is_it, s, a.s);
    a.s0 = select<V>(is_it, s0, a.s0);
    a.mu = select<V>(is_it, V(surface.mu), a.mu);
    a.hold = select<V>(is_it, V(surface.hold), a.hold);
    a.n = select(is_it, n, a.n);
  }
  return a;
}

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline NotAtRest rest_among(const Terms<Scalar<V>>& terms, std::size_t count, Mask<V> lanes,
                                                   Trajectory<V>& m, V* holder = nullptr) noexcept {
  using T = Scalar<V>;
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const V zero(T(0));
  const V direction(terms.h < 0 ? T(-1) : T(1));
  const V h(terms.h);
  const V end_size = one_norm(m.x1);
  const Floor<V> a = floor_of<V, arithmetic>(terms, count, m, one_norm(m.x0), end_size);
  const Mask<V> is_held = lanes & (a.number >= zero);
  if (holder != nullptr) *holder = a.number;
  if (!any_lane<V>(is_held)) return {0, bits_of<V>(lanes), false};

  const V vn = dot<arithmetic>(a.n, m.v1);
  const V vn0 = dot<arithmetic>(a.n, m.v0);
  const Mask<V> is_pressed = direction * vn < zero;
  const V removed = select<V>(is_pressed, magnitude(vn), zero);
  const Three<V> pushed = subtract_product<arithmetic>(m.x1, a.s, a.n);
  const Three<V> v = select(is_pressed, subtract_product<arithmetic>(m.v1, vn, a.n), m.v1);
  const Three<V> v0 = select(direction * vn0 < zero, subtract_product<arithmetic>(m.v0, vn0, a.n), m.v0);

  const V kept = kept_by_friction(a.mu * removed, a.hold * removed, square_root(dot<arithmetic>(v, v)));
  const Three<V> rubbed = kept * v;
  const Three<V> slid = multiply_add<arithmetic>(V(T(0.5)) * h, rubbed - v, pushed);
  const Mask<V> rests = magnitude(h) * one_norm(v0 + rubbed) < V(eps / 4) * end_size;
  const Three<V> x1 = select(rests, subtract_product<arithmetic>(m.x0, a.s0, a.n), slid);
  const Three<V> middle = multiply_add<arithmetic>(V(terms.bend.corner) * h, v0, m.x0);

  const V depth = V(-2 * eps) * end_size;
  Mask<V> pressed(false);
  Mask<V> near(false);
  for (std::size_t j = 0; j < count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const Three<V> n = three<V>(surface.n);
    const V d(surface.d);
    const Mask<V> is_other = a.number != V(static_cast<T>(j));
    const V middle_d(surface.finds_dips ? surface.d : -std::numeric_limits<T>::infinity());
    const Mask<V> is_near = (dot<arithmetic>(n, x1) < d) | (dot<arithmetic>(n, middle) < middle_d);
    pressed = pressed | (is_other & (dot<arithmetic>(n, pushed) - d < depth));
    near = near | (is_other & is_near);
  }
  pressed = pressed & is_held;
  const Mask<V> busy = lanes & ((!is_held) | (near & !pressed));
  const Mask<V> done = is_held & !(near | pressed);
  m.x1 = select(done, x1, m.x1);
  m.v1 = select(done, rubbed, m.v1);
  return {bits_of<V>(pressed), bits_of<V>(busy), any_lane<V>(busy & is_held)};
}

// Unrolls the loops over one and three planes.
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline NotAtRest rest_on_one(const Terms<Scalar<V>>& terms, Mask<V> lanes, Trajectory<V>& m,
                                                    V* holder = nullptr) noexcept {
  switch (terms.surface_count) {
    case 1:
      return rest_among<V, arithmetic>(terms, 1, lanes, m, holder);
    case 3:
      return rest_among<V, arithmetic>(terms, 3, lanes, m, holder);
    default:
      return rest_among<V, arithmetic>(terms, terms.surface_count, lanes, m, holder);
  }
}

}  // namespace
}  // namespace dvdx
