// Bodies with a signed distance, scalar: written by hand beside shape.inl.hpp, with the same letters and order of operations.
// shape.hpp has derivations and sources.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "contact/surfaces/surface.hpp"
#include "simd/particle.hpp"

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
Vector<T> turned_to_body(const Solid<T>& solid, const Vector<T>& r) noexcept {
  return {dot<arithmetic>(solid.axes[0], r), dot<arithmetic>(solid.axes[1], r), dot<arithmetic>(solid.axes[2], r)};
}
template <Arithmetic arithmetic, class T>
Vector<T> to_body(const Surface<T>& surface, const Vector<T>& x) noexcept {
  return turned_to_body<arithmetic>(surface.solid, difference(x, surface.center));
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

// phi of a mesh and its slope, in the body's axes.
template <class T>
struct Sampled {
  T phi;
  Vector<T> slope;
  bool is_beyond;  // outside the grid
};

// y: a position in the body's axes, from its center.
template <Arithmetic arithmetic, class T>
Sampled<T> sample(const Solid<T>& solid, const Vector<T>& y) noexcept {
  Vector<T> part, out;
  std::array<std::size_t, 3> cell;
  bool is_beyond = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const T u = solid.inverse_cell * (y[k] - solid.low[k]);
    const T last = static_cast<T>(solid.nodes[k] - 1);
    const T within = u > 0 ? (u < last ? u : last) : T(0);
    const auto whole = static_cast<std::uint32_t>(within);
    cell[k] = whole < solid.nodes[k] - 2 ? whole : solid.nodes[k] - 2;
    part[k] = within - static_cast<T>(cell[k]);
    is_beyond = is_beyond || u < 0 || u > last;
    const T q = std::abs(y[k]) - solid.half_extents[k];
    out[k] = q > 0 ? q : T(0);
  }
  if (is_beyond) {
    const T phi = std::sqrt(dot<arithmetic>(out, out));
    for (std::size_t k = 0; k < 3; ++k) out[k] = y[k] < 0 ? -out[k] : out[k];
    return {phi, out, true};
  }
  const std::size_t row = solid.nodes[0];
  const std::size_t sheet = row * solid.nodes[1];
  const T* const first = solid.values + cell[2] * sheet + cell[1] * row + cell[0];
  std::array<T, 8> c;
  for (std::size_t n = 0; n < 8; ++n) c[n] = first[(n & 1) + (n >> 1 & 1) * row + (n >> 2) * sheet];
  const auto mixed = [](T w, T a, T b) { return multiply_add<arithmetic>(w, b - a, a); };
  std::array<T, 4> along_x;
  for (std::size_t n = 0; n < 4; ++n) along_x[n] = mixed(part[0], c[2 * n], c[2 * n + 1]);
  const T low = mixed(part[1], along_x[0], along_x[1]);
  const T high = mixed(part[1], along_x[2], along_x[3]);
  const T slope_x = mixed(part[2], mixed(part[1], c[1] - c[0], c[3] - c[2]), mixed(part[1], c[5] - c[4], c[7] - c[6]));
  const T slope_y = mixed(part[2], along_x[1] - along_x[0], along_x[3] - along_x[2]);
  const T inverse = solid.inverse_cell;
  return {mixed(part[2], low, high), {inverse * slope_x, inverse * slope_y, inverse * (high - low)}, false};
}

template <Arithmetic arithmetic, class T>
Touch<T> touch_mesh(const Surface<T>& surface, const Vector<T>& x) noexcept {
  const Solid<T>& solid = surface.solid;
  const Vector<T> y = to_body<arithmetic>(surface, x);
  const T rounding = 8 * std::numeric_limits<T>::epsilon() * (one_norm(y) + surface.radius);
  const Sampled<T> at = sample<arithmetic>(solid, y);
  const T length = std::sqrt(dot<arithmetic>(at.slope, at.slope));
  const T scale = 1 / (length > 0 ? length : T(1));
  const Vector<T> n = {scale * at.slope[0], length > 0 ? scale * at.slope[1] : T(1), scale * at.slope[2]};
  if (!(std::abs(at.phi) > rounding)) return {from_body<arithmetic>(solid, n), T(0)};
  const T first = at.phi / (at.is_beyond ? T(1) : length < T(0.5) ? T(0.5) : length);
  T s = first;
  for (int step = 0; step < normal_steps && std::abs(at.phi) < 2 * solid.cell; ++step) {
    Vector<T> there;
    for (std::size_t k = 0; k < 3; ++k) there[k] = subtract_product<arithmetic>(y[k], s, n[k]);
    const Sampled<T> found = sample<arithmetic>(solid, there);
    if (!(std::abs(found.phi) > rounding)) break;
    const T slope = dot<arithmetic>(n, found.slope);
    s = s + found.phi / (slope > T(0.5) ? slope : T(1));
  }
  return {from_body<arithmetic>(solid, n), s * at.phi > 0 ? s : first};
}

template <Arithmetic arithmetic, class T>
Touch<T> touch_solid(const Surface<T>& surface, const Vector<T>& x) noexcept {
  switch (surface.shape) {
    case Shape::capsule:
      return touch_capsule<arithmetic>(surface, x);
    case Shape::box:
      return touch_box<arithmetic>(surface, x);
    case Shape::mesh:
      return touch_mesh<arithmetic>(surface, x);
    case Shape::convex:
    case Shape::plane:  // planes and spheres are no bodies
    case Shape::sphere:
      break;
  }
  return touch_convex<arithmetic>(surface, x);
}

// ---------------------------------------------------------------------------------- touch test

// Whether the box about a trajectory overlaps the box about the surface's bounding ball.
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
bool may_touch_mesh(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle) noexcept {
  const T phi = sample<arithmetic>(surface.solid, to_body<arithmetic>(surface, p.x0)).phi;
  const T rounding = 16 * std::numeric_limits<T>::epsilon() * (one_norm(p.x0) + surface.radius);
  const auto passes = [&](const Vector<T>& x) {
    const Vector<T> way = difference(x, p.x0);
    return phi <= multiply_add<arithmetic>(surface.solid.steepness, std::sqrt(dot<arithmetic>(way, way)), rounding);
  };
  return passes(p.x1) || (surface.finds_dips && passes(middle));
}

template <Arithmetic arithmetic, class T>
bool may_touch_solid(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle) noexcept {
  if (!overlaps(surface, p, middle)) return false;
  if (surface.shape == Shape::mesh) return may_touch_mesh<arithmetic>(surface, p, middle);
  const Touch<T> start = touch_solid<arithmetic>(surface, p.x0);
  const T rounding = 8 * std::numeric_limits<T>::epsilon() * (one_norm(p.x0) + surface.radius);
  const auto passes = [&](const Vector<T>& x) { return start.s + dot<arithmetic>(start.n, difference(x, p.x0)) <= rounding; };
  return passes(p.x1) || (surface.finds_dips && passes(middle));
}

// ---------------------------------------------------------------------------------- time of impact

// Returns where a path reaches a body, if it does. at: the body as seen from x0, the start of the path x0 + f (u + f a).
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

// Follows the path x0 + f (u + f a) to where it enters a mesh, if it does. start: the mesh as seen from x0.
template <Arithmetic arithmetic, class T>
std::optional<T> march(const Surface<T>& surface, const Vector<T>& x0, const Vector<T>& u, const Vector<T>& a,
                       const Touch<T>& start) noexcept {
  const Solid<T>& solid = surface.solid;
  Vector<T> last;
  for (std::size_t k = 0; k < 3; ++k) last[k] = u[k] + (a[k] + a[k]);
  const T first_speed = std::sqrt(dot<arithmetic>(u, u));
  const T last_speed = std::sqrt(dot<arithmetic>(last, last));
  const T speed = last_speed > first_speed ? last_speed : first_speed;
  const T scale = 1 / (speed > 0 ? speed : T(1));
  const T least = T(0.25) * solid.cell * scale;
  const T reach = 1 / solid.steepness * scale;
  const Vector<T> y0 = to_body<arithmetic>(surface, x0);
  const Vector<T> yu = turned_to_body<arithmetic>(solid, u);
  const Vector<T> ya = turned_to_body<arithmetic>(solid, a);
  const auto phi_at = [&](T f) {
    Vector<T> y;
    for (std::size_t k = 0; k < 3; ++k) y[k] = multiply_add<arithmetic>(f, multiply_add<arithmetic>(f, ya[k], yu[k]), y0[k]);
    return sample<arithmetic>(solid, y).phi;
  };
  if (start.s <= 0 && dot<arithmetic>(start.n, u) < 0) return T(0);
  if (!(speed > 0)) return std::nullopt;

  bool was_out = start.s >= 0;
  bool crosses = false;
  T low = 0;
  T high = 1;
  T phi_low = phi_at(T(0));
  T phi_high = 0;
  for (int step = 0; step < march_steps; ++step) {
    const T by = reach * phi_low;
    const T next = low + (by > least ? by : least);
    const bool is_last = next >= 1;
    const T f = is_last ? T(1) : next;
    const T phi = phi_at(f);
    crosses = was_out && phi < 0;
    (crosses ? high : low) = f;
    (crosses ? phi_high : phi_low) = phi;
    was_out = was_out || phi >= 0;
    if (crosses || is_last) break;
  }
  if (!crosses) return std::nullopt;
  for (int step = 0; step < march_halvings; ++step) {
    const T middle = T(0.5) * (low + high);
    const T phi = phi_at(middle);
    (phi < 0 ? high : low) = middle;
    (phi < 0 ? phi_high : phi_low) = phi;
  }
  if (!(phi_low > 0)) phi_low = 0;
  return multiply_add<arithmetic>(phi_low / (phi_low - phi_high), high - low, low);
}

}  // namespace dvdx::reference
