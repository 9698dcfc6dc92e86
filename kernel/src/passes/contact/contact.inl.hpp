// The contact pass, wide. Formulas only: where they come from stands in contact.hpp, their scalar twin in
// contact_reference.hpp.
#pragma once

#include <cstddef>
#include <limits>

#include "isa/lanes.hpp"
#include "passes/contact/contact.hpp"
#include "passes/terms.hpp"
#include "passes/three.inl.hpp"
#include "passes/trajectory.inl.hpp"

namespace dvdx {
namespace {

// ---------------------------------------------------------------------------------- what every particle pays for

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Mask<V> may_touch_plane(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                                      const Three<V>& middle) noexcept {
  const Three<V> n = three<V>(surface.n);
  const V d(surface.d);
  const Mask<V> ends_inside = dot<arithmetic>(n, m.x1) < d;
  return surface.finds_dips ? ends_inside | (dot<arithmetic>(n, middle) < d) : ends_inside;
}

// Outside a sphere the path is safe where it stays behind the tangent plane whose normal points to its start.
template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Mask<V> may_touch_sphere(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                                       const Three<V>& middle) noexcept {
  const Three<V> c = three<V>(surface.center);
  const V zero(Scalar<V>(0));
  const V square(surface.radius * surface.radius);
  const Three<V> r1 = m.x1 - c;
  const Three<V> rm = middle - c;
  if (surface.side < 0) {
    const Mask<V> ends_outside = dot<arithmetic>(r1, r1) > square;
    return surface.finds_dips ? ends_outside | (dot<arithmetic>(rm, rm) > square) : ends_outside;
  }
  const Three<V> r0 = m.x0 - c;
  const V reach = square * dot<arithmetic>(r0, r0);
  const V along1 = dot<arithmetic>(r0, r1);
  const V along_m = dot<arithmetic>(r0, rm);
  const Mask<V> near1 = (along1 <= zero) | (along1 * along1 <= reach);
  return surface.finds_dips ? near1 | (along_m <= zero) | (along_m * along_m <= reach) : near1;
}

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Mask<V> may_touch(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                                const Three<V>& middle) noexcept {
  switch (surface.shape) {
    case Shape::plane:
      return may_touch_plane<V, arithmetic>(surface, m, middle);
    case Shape::sphere:
      break;
  }
  return may_touch_sphere<V, arithmetic>(surface, m, middle);
}

// Made once a block: what is read through `terms` could alias the particles and would be read again for every batch.
template <class V, Arithmetic arithmetic>
class TouchTest {
  using T = Scalar<V>;

 public:
  explicit TouchTest(const Terms<T>& terms) noexcept
      : first_(terms.surfaces), end_(terms.surfaces + terms.surface_count), half_(terms.h * T(0.5)) {}

  struct Sums {};
  [[gnu::always_inline]] void add(std::size_t, const Trajectory<V>&, Sums&) const noexcept {}

  [[gnu::always_inline]] Mask<V> operator()(const Trajectory<V>& m, const Sums&) const noexcept {
    const Three<V> middle = multiply_add<arithmetic>(half_, m.v0, m.x0);
    Mask<V> touches(false);
    for (const Surface<T>* surface = first_; surface != end_; ++surface) {
      touches = touches | may_touch<V, arithmetic>(*surface, m, middle);
    }
    return touches;
  }

 private:
  const Surface<T>* first_;
  const Surface<T>* end_;
  V half_;
};

// The same for a single plane, axis by axis as soon as it has moved, which takes fewer registers. Where dips do
// not count nothing is below minus infinity.
template <class V, Arithmetic arithmetic>
class PlaneTouchTest {
  using T = Scalar<V>;

 public:
  explicit PlaneTouchTest(const Terms<T>& terms) noexcept
      : n_(three<V>(terms.surfaces[0].n)),
        d_(terms.surfaces[0].d),
        half_(terms.h * T(0.5)),
        middle_d_(terms.surfaces[0].finds_dips ? terms.surfaces[0].d : -std::numeric_limits<T>::infinity()) {}

  struct Sums {
    V end, middle;
  };
  [[gnu::always_inline]] void add(std::size_t axis, const Trajectory<V>& m, Sums& sums) const noexcept {
    accumulate(axis, m.x1[axis], sums.end);
    accumulate(axis, multiply_add<arithmetic>(half_, m.v0[axis], m.x0[axis]), sums.middle);
  }
  [[gnu::always_inline]] Mask<V> operator()(const Trajectory<V>&, const Sums& sums) const noexcept {
    return (sums.end < d_) | (sums.middle < middle_d_);
  }

 private:
  [[gnu::always_inline]] void accumulate(std::size_t axis, V x, V& sum) const noexcept {
    sum = axis == 0 ? n_[0] * x : multiply_add<arithmetic>(n_[axis], x, sum);
  }

  Three<V> n_;
  V d_, half_, middle_d_;
};

// ---------------------------------------------------------------------------------- geometry

template <class V>
struct Touch {
  Three<V> n;  // unit normal
  V s;         // distance, negative inside
};

template <class V, Arithmetic arithmetic>
Touch<V> touch_plane(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  const Three<V> n = three<V>(surface.n);
  return {n, dot<arithmetic>(n, x) - V(surface.d)};
}

template <class V, Arithmetic arithmetic>
Touch<V> touch_sphere(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const V side(surface.side);
  const Three<V> r = x - three<V>(surface.center);
  const V length = square_root(dot<arithmetic>(r, r));
  const Mask<V> has_direction = length > zero;
  const V scale = quotient<V>(side, select<V>(has_direction, length, one));
  // At the very centre every direction is as good: the second axis.
  return {{{scale * r[0], select<V>(has_direction, scale * r[1], side), scale * r[2]}}, side * (length - V(surface.radius))};
}

template <class V, Arithmetic arithmetic>
Touch<V> touch(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  switch (surface.shape) {
    case Shape::plane:
      return touch_plane<V, arithmetic>(surface, x);
    case Shape::sphere:
      break;
  }
  return touch_sphere<V, arithmetic>(surface, x);
}

template <class V>
struct Path {
  Three<V> u, a;
};

template <class V>
Path<V> path(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, V t) noexcept {
  const Three<V> chord = m.x1 - m.x0;
  if (goes_straight(surface)) return {chord, three<V>(V(Scalar<V>(0)))};
  const Three<V> u = t * m.v0;
  return {u, chord - u};
}

template <class V, Arithmetic arithmetic>
Three<V> along(const Three<V>& start, const Path<V>& path, V f) noexcept {
  return multiply_add<arithmetic>(f, multiply_add<arithmetic>(f, path.a, path.u), start);
}

// ---------------------------------------------------------------------------------- time of impact

template <class V>
struct Crossing {
  V f;
  Mask<V> hits;
};

template <class V, Arithmetic arithmetic>
V discriminant(V s0, V d0, V c) noexcept {
  return subtract_product<arithmetic>(d0 * d0, V(Scalar<V>(4)) * c, s0);
}

template <class V>
V first_root(V s0, V d0, V c, V disc) noexcept {
  const V zero(Scalar<V>(0));
  const V root = square_root(select<V>(disc > zero, disc, zero));
  const Mask<V> approaches = d0 < zero;
  const V above = select<V>(approaches, s0 + s0, d0 + select<V>(s0 > zero, root, d0));
  const V below = select<V>(approaches, root - d0, V(Scalar<V>(-2)) * c);
  return quotient<V>(above, below);
}

// Whether what was hit last is not hit again.
template <class V>
Mask<V> stays(const Surface<Scalar<V>>& surface, V d0, V c, V low) noexcept {
  if (surface.response == Response::end_on_surface) return Mask<V>(true);
  return (d0 <= V(Scalar<V>(0))) | (d0 * d0 <= -(low * c));
}

template <class V, Arithmetic arithmetic>
Crossing<V> cross_plane(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, V t, Mask<V> held, V low) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const V start = touch<V, arithmetic>(surface, m.x0).s;
  const V s0 = select<V>(held | (start < zero), zero, start);
  const V s1 = touch<V, arithmetic>(surface, m.x1).s;
  const V d0 = surface.sweep == ContactPath::line ? s1 - s0 : t * dot<arithmetic>(three<V>(surface.n), m.v0);
  const V c = (s1 - s0) - d0;
  const V disc = discriminant<V, arithmetic>(s0, d0, c);
  const V f = first_root(s0, d0, c, disc);
  Mask<V> hits = s1 < zero;
  if (surface.finds_dips) hits = hits | ((d0 < zero) & (disc > zero) & (-d0 < c + c));
  return {select<V>(f < one, f, one), hits & !(held & stays(surface, d0, c, low))};
}

template <class V, Arithmetic arithmetic>
Crossing<V> cross_sphere(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, V t, Mask<V> held, V low) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  const V k(surface.half_curvature);
  const V square(surface.radius * surface.radius);
  const Path<V> way = path(surface, m, t);
  const Three<V> r0 = m.x0 - three<V>(surface.center);
  const Three<V> r1 = m.x1 - three<V>(surface.center);

  const V start = k * (dot<arithmetic>(r0, r0) - square);
  const V g0 = select<V>(held | (start < zero), zero, start);
  const V g1 = k * (dot<arithmetic>(r1, r1) - square);
  const V d0 = (k + k) * dot<arithmetic>(r0, way.u);
  const V across = dot<arithmetic>(r0, way.a);
  const V b = k * (dot<arithmetic>(way.u, way.u) + (across + across));
  const V c = (g1 - g0) - d0;

  const V disc = discriminant<V, arithmetic>(g0, d0, b);
  const V taylor = first_root(g0, d0, b, disc);
  const Mask<V> found = (disc >= zero) & ((d0 < zero) | (b < zero)) & (taylor <= one);
  const V secant = first_root(g0, d0, c, discriminant<V, arithmetic>(g0, d0, c));
  V f = select<V>(found, taylor, secant);
  f = select<V>(f < one, f, one);

  V g = zero;
  V slope = zero;
  for (int step = 0; step <= newton_steps; ++step) {
    const Three<V> r = along<V, arithmetic>(r0, way, f);
    const Three<V> tangent = multiply_add<arithmetic>(f + f, way.a, way.u);
    g = k * (dot<arithmetic>(r, r) - square);
    slope = (k + k) * dot<arithmetic>(r, tangent);
    if (step == newton_steps) break;
    const V next = f - quotient<V>(g, slope);
    f = select<V>((slope < zero) & (next >= zero) & (next <= one), next, f);
  }
  const V scale = (one_norm(r0) + one_norm(way.u)) + V(surface.radius);
  const Mask<V> dips = found & (slope < zero) & (g <= V(16 * std::numeric_limits<T>::epsilon()) * scale);
  return {f, ((g1 < zero) | dips) & !(held & stays(surface, d0, c, low))};
}

template <class V, Arithmetic arithmetic>
Crossing<V> cross(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, V t, Mask<V> held, V low) noexcept {
  switch (surface.shape) {
    case Shape::plane:
      return cross_plane<V, arithmetic>(surface, m, t, held, low);
    case Shape::sphere:
      break;
  }
  return cross_sphere<V, arithmetic>(surface, m, t, held, low);
}

// ---------------------------------------------------------------------------------- impacts and resting

// What friction that can take away `slide` leaves of a tangential velocity; all of it vanishes up to `hold`.
template <class V>
V kept_by_friction(V slide, V hold, V length) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const V kept = select<V>(hold >= length, zero, one - quotient<V>(slide, length));
  return select<V>(hold > zero, kept, one);
}

// Lanes during one step. `last` is the number of the surface that was hit last, `t` what remains of the step.
template <class V>
struct Course {
  V direction, t, last;
  Mask<V> active;
};

// What is left of the tangential velocity at an impact. What lay or slid on the surface before comes to none.
template <class V, Arithmetic arithmetic>
V kept_by_viscosity(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, const Course<V>& course,
                    const Three<V>& gain) noexcept {
  using T = Scalar<V>;
  const V one(T(1));
  if (surface.tau == 1) return one;
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const Touch<V> start = touch<V, arithmetic>(surface, m.x0);
  const V low = V(low_bounce * eps) * (one_norm(m.x0) + V(surface.radius));
  const V out = course.direction * dot<arithmetic>(start.n, m.v0);
  const V own = magnitude(dot<arithmetic>(start.n, gain));
  const V rounding = V(4 * eps) * one_norm(m.v0);
  const Mask<V> is_out = out > V(T(0));
  const Mask<V> stays_low = (out <= rounding) | (out * out * magnitude(course.t) <= V(T(2)) * own * low);
  const Mask<V> comes_slow = -out <= own + rounding;
  const Mask<V> rests = (start.s <= V(T(4)) * low) & ((is_out & stays_low) | ((!is_out) & comes_slow));
  return select<V>(rests, one, V(surface.tau));
}

template <class V, Arithmetic arithmetic>
void respond(const Surface<Scalar<V>>& surface, Trajectory<V>& m, Course<V>& course, V f, Mask<V> hits) noexcept {
  const V one(Scalar<V>(1));
  const V e(surface.e);
  const Three<V> xf = along<V, arithmetic>(m.x0, path(surface, m, course.t), f);
  const Three<V> gain = m.v1 - m.v0;
  const Three<V> vf = multiply_add<arithmetic>(f, gain, m.v0);
  const Three<V> n = touch<V, arithmetic>(surface, xf).n;
  const V vn = dot<arithmetic>(n, vf);
  const Mask<V> acts = hits & (course.direction * vn <= V(Scalar<V>(0)));

  const V tau = kept_by_viscosity<V, arithmetic>(surface, m, course, gain);
  const Three<V> vt = tau * subtract_product<arithmetic>(vf, vn, n);
  const V slide = V(surface.mu) * ((one + e) * magnitude(vn));
  const V kept = kept_by_friction(slide, slide, square_root(dot<arithmetic>(vt, vt)));
  const Three<V> after = subtract_product<arithmetic>(kept * vt, e * vn, n);
  const V rest = one - f;
  const V t = rest * course.t;
  const V beyond = dot<arithmetic>(n, m.x1 - xf);
  const Three<V> moved = surface.response == Response::end_on_surface ? subtract_product<arithmetic>(m.x1, beyond, n)
                                                                      : multiply_add<arithmetic>(t, after - vf, m.x1);

  m.x1 = select(acts, moved, m.x1);
  m.v1 = select(acts, multiply_add<arithmetic>(rest, gain, after), m.v1);
  m.x0 = select(hits, xf, m.x0);
  m.v0 = select(acts, after, select(hits, vf, m.v0));
  course.t = select<V>(hits, t, course.t);
}

// The earliest impact of every lane; false where none remains.
template <class V, Arithmetic arithmetic>
bool resolve_earliest(const Terms<Scalar<V>>& terms, Trajectory<V>& m, Course<V>& course) noexcept {
  using T = Scalar<V>;
  const V low = V(4 * low_bounce * std::numeric_limits<T>::epsilon()) * one_norm(m.x0);
  V earliest(T(2));
  V which(T(-1));
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const V number(static_cast<T>(j));
    const Crossing<V> crossing = cross<V, arithmetic>(terms.surfaces[j], m, course.t, course.last == number, low);
    const Mask<V> is_earlier = course.active & crossing.hits & (crossing.f < earliest);
    earliest = select<V>(is_earlier, crossing.f, earliest);
    which = select<V>(is_earlier, number, which);
  }
  course.active = course.active & (which >= V(T(0)));
  if (!any_lane<V>(course.active)) return false;
  course.last = select<V>(course.active, which, course.last);
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Mask<V> hits = which == V(static_cast<T>(j));
    if (any_lane<V>(hits)) respond<V, arithmetic>(terms.surfaces[j], m, course, earliest, hits);
  }
  return true;
}

template <class V, Arithmetic arithmetic>
void clamp(const Surface<Scalar<V>>& surface, Trajectory<V>& m, const Course<V>& course, Mask<V> held, Mask<V> inside,
           V size) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const Three<V> n = touch<V, arithmetic>(surface, m.x1).n;
  const V vn = dot<arithmetic>(n, m.v1);
  const V removed = magnitude(vn);
  const Three<V> vt = subtract_product<arithmetic>(m.v1, vn, n);
  const V length = square_root(dot<arithmetic>(vt, vt));
  const V kept = kept_by_friction(V(surface.mu) * removed, V(surface.hold) * removed, length);
  m.v1 = select(inside & (course.direction * vn < zero), kept * vt, m.v1);

  const V motion = magnitude(course.t) * one_norm(m.v0 + m.v1);
  const Mask<V> rests = held & (motion < V(std::numeric_limits<T>::epsilon() / 4) * size);
  const Three<V> base = select(rests, m.x0, m.x1);
  const Touch<V> there = touch<V, arithmetic>(surface, base);
  m.x1 = select(inside, subtract_product<arithmetic>(base, there.s, there.n), m.x1);
}

template <class V, Arithmetic arithmetic>
void clamp_all(const Terms<Scalar<V>>& terms, Trajectory<V>& m, const Course<V>& course, Mask<V> touches) noexcept {
  using T = Scalar<V>;
  V tolerance(T(0));
  for (int round = 0; round < clamp_rounds; ++round) {
    bool is_clamped = false;
    for (std::size_t j = 0; j < terms.surface_count; ++j) {
      const auto& surface = terms.surfaces[j];
      const V size = one_norm(m.x1);
      const Mask<V> inside = touches & (touch<V, arithmetic>(surface, m.x1).s < -(tolerance * size));
      if (!any_lane<V>(inside)) continue;
      is_clamped = true;
      clamp<V, arithmetic>(surface, m, course, course.last == V(static_cast<T>(j)), inside, size);
    }
    if (!is_clamped) return;
    tolerance = V(2 * std::numeric_limits<T>::epsilon());
  }
}

// The rare path, out of line. Only lanes in `touches` change, so that a particle's bits do not depend on its neighbours.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] void resolve_touching(const Terms<Scalar<V>>& terms, Mask<V> touches, Trajectory<V>& m) noexcept {
  using T = Scalar<V>;
  Course<V> course{.direction = V(terms.h < 0 ? T(-1) : T(1)), .t = V(terms.h), .last = V(T(-1)), .active = touches};
  for (int impact = 0; impact < terms.impacts; ++impact) {
    if (!resolve_earliest<V, arithmetic>(terms, m, course)) break;
  }
  clamp_all<V, arithmetic>(terms, m, course, touches);
}

template <class V>
[[gnu::always_inline]] inline Three<V> copied(const Three<V>& a) noexcept {
  return {{a[0], a[1], a[2]}};
}

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline void resolve_contacts(const Terms<Scalar<V>>& terms, Trajectory<V>& m) noexcept {
  const Mask<V> touches = TouchTest<V, arithmetic>(terms)(m, {});
  if (!any_lane<V>(touches)) [[likely]]
    return;
  // The original never has its address taken, and is copied register by register, so that it stays in registers elsewhere.
  Trajectory<V> copy{copied(m.x0), copied(m.v0), copied(m.x1), copied(m.v1)};
  resolve_touching<V, arithmetic>(terms, touches, copy);
  m.x1 = copied(copy.x1);
  m.v1 = copied(copy.v1);
}

}  // namespace
}  // namespace dvdx
