// Bodies with a signed distance, scalar: written by hand beside shape.inl.hpp, the same letters in the same order of
// operations. Derivations and sources stand in shape.hpp.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "passes/contact/contact.hpp"
#include "passes/particle.hpp"

namespace dvdx::reference {

template <class T>
using Vector = std::array<T, 3>;

template <class T>
struct Touch {
  Vector<T> n{};
  T s = 0;
};

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

template <Arithmetic arithmetic, class T>
T discriminant(T s0, T d0, T c) noexcept;
template <class T>
T first_root(T s0, T d0, T c, T disc) noexcept;

// ---------------------------------------------------------------------------------- distance

template <Arithmetic arithmetic, class T>
Touch<T> touch_capsule(const Surface<T>& surface, const Vector<T>& x) noexcept {
  const Solid<T>& solid = surface.solid;
  const Vector<T>& w = solid.axes[0];
  const Vector<T> y = difference(x, surface.center);
  const T eta = dot<arithmetic>(w, y);
  T l = eta;
  if (solid.lean != 0) {
    Vector<T> across;
    for (std::size_t k = 0; k < 3; ++k) across[k] = subtract_product<arithmetic>(y[k], eta, w[k]);
    l = multiply_add<arithmetic>(solid.lean, std::sqrt(dot<arithmetic>(across, across)), eta);
  }
  if (l > solid.half_length) l = solid.half_length;
  if (l < -solid.half_length) l = -solid.half_length;
  Vector<T> r;
  for (std::size_t k = 0; k < 3; ++k) r[k] = subtract_product<arithmetic>(y[k], l, w[k]);
  const T length = std::sqrt(dot<arithmetic>(r, r));
  Touch<T> touch{solid.axes[1], length - multiply_add<arithmetic>(solid.slope, l, solid.middle_radius)};
  if (!(length > 0)) return touch;
  const T scale = 1 / length;
  for (std::size_t k = 0; k < 3; ++k) touch.n[k] = scale * r[k];
  return touch;
}

template <Arithmetic arithmetic, class T>
Vector<T> from_body(const Solid<T>& solid, const Vector<T>& n) noexcept {
  Vector<T> to;
  for (std::size_t k = 0; k < 3; ++k) {
    const T two = multiply_add<arithmetic>(n[1], solid.axes[1][k], n[0] * solid.axes[0][k]);
    to[k] = multiply_add<arithmetic>(n[2], solid.axes[2][k], two);
  }
  return to;
}
template <Arithmetic arithmetic, class T>
Vector<T> to_body(const Surface<T>& surface, const Vector<T>& x) noexcept {
  const Vector<T> r = difference(x, surface.center);
  const auto& axes = surface.solid.axes;
  return {dot<arithmetic>(axes[0], r), dot<arithmetic>(axes[1], r), dot<arithmetic>(axes[2], r)};
}

template <Arithmetic arithmetic, class T>
Touch<T> touch_box(const Surface<T>& surface, const Vector<T>& x) noexcept {
  const Solid<T>& solid = surface.solid;
  const Vector<T> y = to_body<arithmetic>(surface, x);
  Vector<T> q, out, n{};
  for (std::size_t k = 0; k < 3; ++k) {
    q[k] = std::abs(y[k]) - solid.half_extents[k];
    out[k] = q[k] > 0 ? q[k] : T(0);
  }
  const T length = std::sqrt(dot<arithmetic>(out, out));
  T s = length;
  if (length > 0) {
    const T scale = 1 / length;
    for (std::size_t k = 0; k < 3; ++k) n[k] = scale * out[k];
  } else {
    std::size_t largest = q[1] > q[0] ? 1 : 0;
    if (q[2] > q[largest]) largest = 2;
    s = q[largest];
    n[largest] = 1;
  }
  for (std::size_t k = 0; k < 3; ++k) n[k] = y[k] < 0 ? -n[k] : n[k];
  return {from_body<arithmetic>(solid, n), s - solid.thickness};
}

template <Arithmetic arithmetic, class T>
Touch<T> touch_convex(const Surface<T>& surface, const Vector<T>& x) noexcept {
  const Solid<T>& solid = surface.solid;
  const Vector<T> y = to_body<arithmetic>(surface, x);
  Vector<T> n{};
  T s = -std::numeric_limits<T>::infinity();
  for (std::size_t k = 0; k < solid.plane_count; ++k) {
    const Vector<T> normal = {solid.planes[k][0], solid.planes[k][1], solid.planes[k][2]};
    const T gap = dot<arithmetic>(normal, y) - solid.planes[k][3];
    if (!(gap > s)) continue;
    s = gap;
    n = normal;
  }
  return {from_body<arithmetic>(solid, n), s};
}

template <Arithmetic arithmetic, class T>
Touch<T> touch_solid(const Surface<T>& surface, const Vector<T>& x) noexcept {
  if (surface.shape == Shape::capsule) return touch_capsule<arithmetic>(surface, x);
  if (surface.shape == Shape::box) return touch_box<arithmetic>(surface, x);
  return touch_convex<arithmetic>(surface, x);
}

// ---------------------------------------------------------------------------------- does anything happen at all

// Whether the box about a trajectory overlaps the box about what the surface's radius bounds.
template <class T>
bool overlaps(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle) noexcept {
  for (std::size_t k = 0; k < 3; ++k) {
    T low = p.x1[k] < p.x0[k] ? p.x1[k] : p.x0[k];
    T high = p.x1[k] > p.x0[k] ? p.x1[k] : p.x0[k];
    if (surface.finds_dips) {
      low = middle[k] < low ? middle[k] : low;
      high = middle[k] > high ? middle[k] : high;
    }
    if (!(low <= surface.center[k] + surface.radius && high >= surface.center[k] - surface.radius)) return false;
  }
  return true;
}

template <Arithmetic arithmetic, class T>
bool may_touch_solid(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle) noexcept {
  if (!overlaps(surface, p, middle)) return false;
  const Touch<T> start = touch_solid<arithmetic>(surface, p.x0);
  const T rounding = 8 * std::numeric_limits<T>::epsilon() * (one_norm(p.x0) + surface.radius);
  const auto passes = [&](const Vector<T>& x) { return start.s + dot<arithmetic>(start.n, difference(x, p.x0)) <= rounding; };
  return passes(p.x1) || (surface.finds_dips && passes(middle));
}

// ---------------------------------------------------------------------------------- time of impact

// Where a path comes to a body, if it does.
template <Arithmetic arithmetic, class T>
std::optional<T> approach(const Surface<T>& surface, const Vector<T>& x0, const Vector<T>& u, const Vector<T>& a, Touch<T> at,
                          T tolerance) noexcept {
  T f = 0;
  for (int step = 0; step < approach_steps; ++step) {
    Vector<T> tangent;
    for (std::size_t k = 0; k < 3; ++k) tangent[k] = multiply_add<arithmetic>(f + f, a[k], u[k]);
    const T d = dot<arithmetic>(at.n, tangent);
    const T c = dot<arithmetic>(at.n, a);
    const T disc = discriminant<arithmetic>(at.s, d, c);
    const T next = f + first_root(at.s, d, c, disc);
    if (!(disc >= 0 && (d < 0 || c < 0) && next <= 1)) return std::nullopt;
    f = next;
    Vector<T> x;
    for (std::size_t k = 0; k < 3; ++k) x[k] = multiply_add<arithmetic>(f, multiply_add<arithmetic>(f, a[k], u[k]), x0[k]);
    at = touch_solid<arithmetic>(surface, x);
    if (at.s <= tolerance) return f;
  }
  return std::nullopt;
}

}  // namespace dvdx::reference
