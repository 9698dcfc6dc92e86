// Bodies with a signed distance, wide. Formulas only: where they come from stands in shape.hpp, their scalar twin in
// shape_reference.hpp.
#pragma once

#include <cstddef>
#include <limits>

#include "passes/contact/contact.hpp"
#include "passes/three.inl.hpp"
#include "passes/trajectory.inl.hpp"

namespace dvdx {
namespace {

template <class V>
struct Touch {
  Three<V> n;  // unit normal
  V s;         // distance, negative inside
};

template <class V, Arithmetic arithmetic>
V discriminant(V s0, V d0, V c) noexcept;
template <class V>
V first_root(V s0, V d0, V c, V disc) noexcept;

// ---------------------------------------------------------------------------------- distance

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Touch<V> touch_capsule(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  using T = Scalar<V>;
  const Solid<T>& solid = surface.solid;
  const V zero(T(0));
  const V end(solid.half_length);
  const Three<V> w = three<V>(solid.axes[0]);
  const Three<V> y = x - three<V>(surface.center);
  const V eta = dot<arithmetic>(w, y);
  V l = eta;
  if (solid.lean != 0) {
    const Three<V> across = subtract_product<arithmetic>(y, eta, w);
    l = multiply_add<arithmetic>(V(solid.lean), square_root(dot<arithmetic>(across, across)), eta);
  }
  l = select<V>(l < -end, -end, select<V>(l > end, end, l));
  const Three<V> r = subtract_product<arithmetic>(y, l, w);
  const V length = square_root(dot<arithmetic>(r, r));
  const Mask<V> has_direction = length > zero;
  const V scale = quotient<V>(V(T(1)), select<V>(has_direction, length, V(T(1))));
  // On the line itself every direction across it is as good.
  return {select(has_direction, scale * r, three<V>(solid.axes[1])),
          length - multiply_add<arithmetic>(V(solid.slope), l, V(solid.middle_radius))};
}

template <class V>
struct BodyTouch {
  Three<V> n;  // in the body's axes
  V s;
};

// From the body's axes to the world's.
template <class V, Arithmetic arithmetic>
Three<V> from_body(const Solid<Scalar<V>>& solid, const Three<V>& n) noexcept {
  const Three<V> first = n[0] * three<V>(solid.axes[0]);
  return multiply_add<arithmetic>(n[2], three<V>(solid.axes[2]),
                                  multiply_add<arithmetic>(n[1], three<V>(solid.axes[1]), first));
}
template <class V, Arithmetic arithmetic>
Three<V> to_body(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  const Three<V> r = x - three<V>(surface.center);
  const auto& axes = surface.solid.axes;
  return {
      {dot<arithmetic>(three<V>(axes[0]), r), dot<arithmetic>(three<V>(axes[1]), r), dot<arithmetic>(three<V>(axes[2]), r)}};
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Touch<V> touch_box(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  using T = Scalar<V>;
  const Solid<T>& solid = surface.solid;
  const V zero(T(0));
  const V one(T(1));
  const Three<V> y = to_body<V, arithmetic>(surface, x);
  Three<V> q, out;
  for (std::size_t k = 0; k < 3; ++k) {
    q[k] = magnitude(y[k]) - V(solid.half_extents[k]);
    out[k] = select<V>(q[k] > zero, q[k], zero);
  }
  const V length = square_root(dot<arithmetic>(out, out));
  const Mask<V> is_outside = length > zero;
  const V scale = quotient<V>(one, select<V>(is_outside, length, one));
  const Mask<V> is_second = q[1] > q[0];
  const V largest = select<V>(is_second, q[1], q[0]);
  const Mask<V> is_third = q[2] > largest;
  const Three<V> face = {{select<V>(is_second | is_third, zero, one),
                          select<V>(is_third, zero, select<V>(is_second, one, zero)), select<V>(is_third, one, zero)}};
  Three<V> n = select(is_outside, scale * out, face);
  for (std::size_t k = 0; k < 3; ++k) n[k] = select<V>(y[k] < zero, -n[k], n[k]);
  const V s = select<V>(is_outside, length, select<V>(is_third, q[2], largest));
  return {from_body<V, arithmetic>(solid, n), s - V(solid.thickness)};
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Touch<V> touch_convex(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  using T = Scalar<V>;
  const Solid<T>& solid = surface.solid;
  const Three<V> y = to_body<V, arithmetic>(surface, x);
  Three<V> n = three<V>(V(T(0)));
  V s(-std::numeric_limits<T>::infinity());
  for (std::size_t k = 0; k < solid.plane_count; ++k) {
    const auto& plane = solid.planes[k];
    const Three<V> normal = {{V(plane[0]), V(plane[1]), V(plane[2])}};
    const V gap = dot<arithmetic>(normal, y) - V(plane[3]);
    const Mask<V> is_it = gap > s;
    s = select<V>(is_it, gap, s);
    n = select(is_it, normal, n);
  }
  return {from_body<V, arithmetic>(solid, n), s};
}

template <class V, Arithmetic arithmetic>
Touch<V> touch_solid(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  if (surface.shape == Shape::capsule) return touch_capsule<V, arithmetic>(surface, x);
  if (surface.shape == Shape::box) return touch_box<V, arithmetic>(surface, x);
  return touch_convex<V, arithmetic>(surface, x);
}

// ---------------------------------------------------------------------------------- what every particle near it pays for

// Whether the box about a trajectory overlaps the box about what the surface's radius bounds.
template <class V>
Mask<V> overlaps(const Surface<Scalar<V>>& surface, const Trajectory<V>& m, const Three<V>& middle) noexcept {
  Mask<V> near(true);
  for (std::size_t k = 0; k < 3; ++k) {
    V low = select<V>(m.x1[k] < m.x0[k], m.x1[k], m.x0[k]);
    V high = select<V>(m.x1[k] > m.x0[k], m.x1[k], m.x0[k]);
    if (surface.finds_dips) {
      low = select<V>(middle[k] < low, middle[k], low);
      high = select<V>(middle[k] > high, middle[k], high);
    }
    near = near & (low <= V(surface.center[k] + surface.radius)) & (high >= V(surface.center[k] - surface.radius));
  }
  return near;
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Mask<V> may_touch_solid(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                          const Three<V>& middle) noexcept {
  using T = Scalar<V>;
  const Mask<V> near = overlaps(surface, m, middle);
  if (!any_lane<V>(near)) return near;
  const Touch<V> start = touch_solid<V, arithmetic>(surface, m.x0);
  const V rounding = V(8 * std::numeric_limits<T>::epsilon()) * (one_norm(m.x0) + V(surface.radius));
  const auto passes = [&](const Three<V>& x) { return start.s + dot<arithmetic>(start.n, x - m.x0) <= rounding; };
  return near & (surface.finds_dips ? passes(m.x1) | passes(middle) : passes(m.x1));
}

// ---------------------------------------------------------------------------------- time of impact

// Where a path comes to a body, from tangent plane to tangent plane.
template <class V>
struct Approach {
  V f;
  Mask<V> arrives;
};

// at: the body from x0, the start of the path x0 + f (u + f a).
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Approach<V> approach(const Surface<Scalar<V>>& surface, const Three<V>& x0, const Three<V>& u,
                                       const Three<V>& a, Touch<V> at, V tolerance, Mask<V> lanes) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  Approach<V> found{zero, Mask<V>(false)};
  for (int step = 0; step < approach_steps && any_lane<V>(lanes); ++step) {
    const V d = dot<arithmetic>(at.n, multiply_add<arithmetic>(found.f + found.f, a, u));
    const V c = dot<arithmetic>(at.n, a);
    const V disc = discriminant<V, arithmetic>(at.s, d, c);
    const V next = found.f + first_root(at.s, d, c, disc);
    lanes = lanes & (disc >= zero) & ((d < zero) | (c < zero)) & (next <= one);
    found.f = select<V>(lanes, next, found.f);
    const Three<V> x = multiply_add<arithmetic>(found.f, multiply_add<arithmetic>(found.f, a, u), x0);
    at = touch_solid<V, arithmetic>(surface, x);
    const Mask<V> is_there = at.s <= tolerance;
    found.arrives = found.arrives | (lanes & is_there);
    lanes = lanes & !is_there;
  }
  return found;
}

}  // namespace
}  // namespace dvdx
