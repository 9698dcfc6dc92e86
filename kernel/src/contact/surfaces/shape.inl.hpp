// Bodies with a signed distance, wide. shape.hpp derives the formulas; the scalar twin is shape_reference.hpp.
#pragma once

#include <cstddef>
#include <limits>

#include "contact/surfaces/surface.hpp"
#include "simd/three.inl.hpp"
#include "simd/trajectory.inl.hpp"

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
  l = select<V>(l < negative(end), negative(end), select<V>(l > end, end, l));
  const Three<V> r = subtract_product<arithmetic>(y, l, w);
  const V length = square_root(dot<arithmetic>(r, r));
  const Mask<V> has_direction = length > zero;
  const V scale = quotient<V>(V(T(1)), select<V>(has_direction, length, V(T(1))));
  // On the line itself any direction across it will do: the second axis.
  return {select(has_direction, scale * r, three<V>(solid.axes[1])),
          length - multiply_add<arithmetic>(V(solid.slope), l, V(solid.middle_radius))};
}

template <class V>
struct BodyTouch {
  Three<V> n;  // in the body's axes
  V s;
};

// Turns a vector from the body's axes to the world's.
template <class V, Arithmetic arithmetic>
Three<V> from_body(const Solid<Scalar<V>>& solid, const Three<V>& n) noexcept {
  const Three<V> first = n[0] * three<V>(solid.axes[0]);
  return multiply_add<arithmetic>(n[2], three<V>(solid.axes[2]),
                                  multiply_add<arithmetic>(n[1], three<V>(solid.axes[1]), first));
}
template <class V, Arithmetic arithmetic>
Three<V> turned_to_body(const Solid<Scalar<V>>& solid, const Three<V>& r) noexcept {
  return {{dot<arithmetic>(three<V>(solid.axes[0]), r), dot<arithmetic>(three<V>(solid.axes[1]), r),
           dot<arithmetic>(three<V>(solid.axes[2]), r)}};
}
template <class V, Arithmetic arithmetic>
Three<V> to_body(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  return turned_to_body<V, arithmetic>(surface.solid, x - three<V>(surface.center));
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
  for (std::size_t k = 0; k < 3; ++k) n[k] = select<V>(y[k] < zero, negative(n[k]), n[k]);
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

// phi of a mesh and its slope, in the body's axes.
template <class V>
struct Sampled {
  V phi;
  Three<V> slope;
  Mask<V> is_beyond;  // outside the grid
};

template <class V>
struct Corners {
  V at[8];  // of a lane's cell, x fastest
};

template <class V>
Corners<V> corners_of(const Solid<Scalar<V>>& solid, const Three<V>& cell) noexcept {
  using T = Scalar<V>;
  alignas(64) T index[3][V::size];
  alignas(64) T values[8][V::size];
  for (std::size_t k = 0; k < 3; ++k) store_lanes(index[k], cell[k]);
  const std::size_t row = solid.nodes[0];
  const std::size_t sheet = row * solid.nodes[1];
  for (std::size_t lane = 0; lane < V::size; ++lane) {
    const T* const first = solid.values + static_cast<std::size_t>(index[2][lane]) * sheet +
                           static_cast<std::size_t>(index[1][lane]) * row + static_cast<std::size_t>(index[0][lane]);
    for (std::size_t n = 0; n < 8; ++n) values[n][lane] = first[(n & 1) + (n >> 1 & 1) * row + (n >> 2) * sheet];
  }
  Corners<V> corners;
  for (std::size_t n = 0; n < 8; ++n) corners.at[n] = load_lanes<V>(values[n]);
  return corners;
}

// Returns the integer parts of numbers >= 0, at most `most`.
template <class V>
V whole_part(V u, std::uint32_t most) noexcept {
  using T = Scalar<V>;
  alignas(64) T lanes[V::size];
  store_lanes(lanes, u);
  for (T& lane : lanes) {
    const auto whole = static_cast<std::uint32_t>(lane);
    lane = static_cast<T>(whole < most ? whole : most);
  }
  return load_lanes<V>(lanes);
}

// y: a position in the body's axes, from its center.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Sampled<V> sample(const Solid<Scalar<V>>& solid, const Three<V>& y) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  Three<V> cell, part, out;
  Mask<V> is_beyond(false);
  for (std::size_t k = 0; k < 3; ++k) {
    const V u = V(solid.inverse_cell) * (y[k] - V(solid.low[k]));
    const V last(static_cast<T>(solid.nodes[k] - 1));
    const V within = select<V>(u > zero, select<V>(u < last, u, last), zero);  // 0 for NaN
    cell[k] = whole_part(within, solid.nodes[k] - 2);
    part[k] = within - cell[k];
    is_beyond = is_beyond | (u < zero) | (u > last);
    const V q = magnitude(y[k]) - V(solid.half_extents[k]);
    out[k] = select<V>(q > zero, q, zero);
  }
  const Corners<V> c = corners_of<V>(solid, cell);
  const auto mixed = [](V w, V a, V b) { return multiply_add<arithmetic>(w, b - a, a); };
  V along_x[4];
  for (std::size_t n = 0; n < 4; ++n) along_x[n] = mixed(part[0], c.at[2 * n], c.at[2 * n + 1]);
  const V low = mixed(part[1], along_x[0], along_x[1]);
  const V high = mixed(part[1], along_x[2], along_x[3]);
  const V slope_x = mixed(part[2], mixed(part[1], c.at[1] - c.at[0], c.at[3] - c.at[2]),
                          mixed(part[1], c.at[5] - c.at[4], c.at[7] - c.at[6]));
  const V slope_y = mixed(part[2], along_x[1] - along_x[0], along_x[3] - along_x[2]);
  const V inverse(solid.inverse_cell);
  Sampled<V> at{mixed(part[2], low, high), inverse * Three<V>{{slope_x, slope_y, high - low}}, is_beyond};
  if (!any_lane<V>(is_beyond)) return at;
  at.phi = select<V>(is_beyond, square_root(dot<arithmetic>(out, out)), at.phi);
  for (std::size_t k = 0; k < 3; ++k) {
    at.slope[k] = select<V>(is_beyond, select<V>(y[k] < zero, negative(out[k]), out[k]), at.slope[k]);
  }
  return at;
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Touch<V> touch_mesh(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  using T = Scalar<V>;
  const Solid<T>& solid = surface.solid;
  const V zero(T(0));
  const V one(T(1));
  const V half(T(0.5));
  const Three<V> y = to_body<V, arithmetic>(surface, x);
  const V rounding = V(8 * std::numeric_limits<T>::epsilon()) * (one_norm(y) + V(surface.radius));
  const Sampled<V> at = sample<V, arithmetic>(solid, y);
  const V length = square_root(dot<arithmetic>(at.slope, at.slope));
  const Mask<V> has_direction = length > zero;
  const V scale = quotient<V>(one, select<V>(has_direction, length, one));
  // Where the slope vanishes any direction will do: the second axis.
  const Three<V> n = {{scale * at.slope[0], select<V>(has_direction, scale * at.slope[1], one), scale * at.slope[2]}};
  const V first = quotient<V>(at.phi, select<V>(at.is_beyond, one, select<V>(length < half, half, length)));
  V s = first;
  Mask<V> lanes = (magnitude(at.phi) > rounding) & (magnitude(at.phi) < V(2 * solid.cell));
  for (int step = 0; step < normal_steps && any_lane<V>(lanes); ++step) {
    const Sampled<V> there = sample<V, arithmetic>(solid, subtract_product<arithmetic>(y, s, n));
    lanes = lanes & (magnitude(there.phi) > rounding);
    const V slope = dot<arithmetic>(n, there.slope);
    s = select<V>(lanes, s + quotient<V>(there.phi, select<V>(slope > half, slope, one)), s);
  }
  s = select<V>(s * at.phi > zero, s, first);
  return {from_body<V, arithmetic>(solid, n), select<V>(magnitude(at.phi) > rounding, s, zero)};
}

template <class V, Arithmetic arithmetic>
Touch<V> touch_solid(const Surface<Scalar<V>>& surface, const Three<V>& x) noexcept {
  switch (surface.shape) {
    case Shape::capsule:
      return touch_capsule<V, arithmetic>(surface, x);
    case Shape::box:
      return touch_box<V, arithmetic>(surface, x);
    case Shape::mesh:
      return touch_mesh<V, arithmetic>(surface, x);
    case Shape::convex:
    case Shape::plane:  // planes and spheres are no bodies
    case Shape::sphere:
      break;
  }
  return touch_convex<V, arithmetic>(surface, x);
}

// ---------------------------------------------------------------------------------- touch test

// Whether the box about a trajectory overlaps the box about the surface's bounding ball.
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

// The surface is no nearer than phi/L, and the path goes no further from its start than its corners do.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Mask<V> may_touch_mesh(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                         const Three<V>& middle) noexcept {
  using T = Scalar<V>;
  const V phi = sample<V, arithmetic>(surface.solid, to_body<V, arithmetic>(surface, m.x0)).phi;
  const V rounding = V(16 * std::numeric_limits<T>::epsilon()) * (one_norm(m.x0) + V(surface.radius));
  const auto passes = [&](const Three<V>& x) {
    const Three<V> way = x - m.x0;
    return phi <= multiply_add<arithmetic>(V(surface.solid.steepness), square_root(dot<arithmetic>(way, way)), rounding);
  };
  return surface.finds_dips ? passes(m.x1) | passes(middle) : passes(m.x1);
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Mask<V> may_touch_solid(const Surface<Scalar<V>>& surface, const Trajectory<V>& m,
                                          const Three<V>& middle) noexcept {
  using T = Scalar<V>;
  const Mask<V> near = overlaps(surface, m, middle);
  if (!any_lane<V>(near)) return near;
  if (surface.shape == Shape::mesh) return near & may_touch_mesh<V, arithmetic>(surface, m, middle);
  const Touch<V> start = touch_solid<V, arithmetic>(surface, m.x0);
  const V rounding = V(8 * std::numeric_limits<T>::epsilon()) * (one_norm(m.x0) + V(surface.radius));
  const auto passes = [&](const Three<V>& x) { return start.s + dot<arithmetic>(start.n, x - m.x0) <= rounding; };
  return near & (surface.finds_dips ? passes(m.x1) | passes(middle) : passes(m.x1));
}

// ---------------------------------------------------------------------------------- time of impact

// Where a path reaches a body.
template <class V>
struct Approach {
  V f;
  Mask<V> arrives;
};

// Steps from tangent plane to tangent plane. at: the body as seen from x0, the start of the path x0 + f (u + f a).
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

// Follows the path x0 + f (u + f a) to where it enters a mesh. start: the mesh as seen from x0.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Approach<V> march(const Surface<Scalar<V>>& surface, const Three<V>& x0, const Three<V>& u, const Three<V>& a,
                                    const Touch<V>& start, Mask<V> lanes) noexcept {
  using T = Scalar<V>;
  const Solid<T>& solid = surface.solid;
  const V zero(T(0));
  const V one(T(1));
  const Three<V> last = u + (a + a);
  const V first_speed = square_root(dot<arithmetic>(u, u));
  const V last_speed = square_root(dot<arithmetic>(last, last));
  const V speed = select<V>(last_speed > first_speed, last_speed, first_speed);
  const V scale = quotient<V>(one, select<V>(speed > zero, speed, one));
  const V least = V(T(0.25) * solid.cell) * scale;
  const V reach = V(1 / solid.steepness) * scale;
  const Three<V> y0 = to_body<V, arithmetic>(surface, x0);
  const Three<V> yu = turned_to_body<V, arithmetic>(solid, u);
  const Three<V> ya = turned_to_body<V, arithmetic>(solid, a);
  const auto phi_at = [&](V f) {
    return sample<V, arithmetic>(solid, multiply_add<arithmetic>(f, multiply_add<arithmetic>(f, ya, yu), y0)).phi;
  };
  const Mask<V> is_in = lanes & (start.s <= zero) & (dot<arithmetic>(start.n, u) < zero);
  lanes = lanes & (!is_in) & (speed > zero);
  Approach<V> found{zero, is_in};
  if (!any_lane<V>(lanes)) return found;

  Mask<V> was_out = start.s >= zero;
  Mask<V> crosses(false);
  V low = zero;
  V high = one;
  V phi_low = phi_at(zero);
  V phi_high = zero;
  for (int step = 0; step < march_steps && any_lane<V>(lanes); ++step) {
    const V by = reach * phi_low;
    const V next = low + select<V>(by > least, by, least);
    const Mask<V> is_last = next >= one;
    const V f = select<V>(is_last, one, next);
    const V phi = phi_at(f);
    const Mask<V> is_through = lanes & was_out & (phi < zero);
    crosses = crosses | is_through;
    high = select<V>(is_through, f, high);
    phi_high = select<V>(is_through, phi, phi_high);
    lanes = lanes & !is_through;
    low = select<V>(lanes, f, low);
    phi_low = select<V>(lanes, phi, phi_low);
    was_out = was_out | (phi >= zero);
    lanes = lanes & !is_last;
  }
  if (!any_lane<V>(crosses)) return found;
  for (int step = 0; step < march_halvings; ++step) {
    const V middle = V(T(0.5)) * (low + high);
    const V phi = phi_at(middle);
    const Mask<V> is_through = phi < zero;
    high = select<V>(is_through, middle, high);
    phi_high = select<V>(is_through, phi, phi_high);
    low = select<V>(is_through, low, middle);
    phi_low = select<V>(is_through, phi_low, phi);
  }
  phi_low = select<V>(phi_low > zero, phi_low, zero);
  const V part = quotient<V>(phi_low, select<V>(crosses, phi_low - phi_high, one));
  found.f = select<V>(crosses, multiply_add<arithmetic>(part, high - low, low), zero);
  found.arrives = is_in | crosses;
  return found;
}

}  // namespace
}  // namespace dvdx
