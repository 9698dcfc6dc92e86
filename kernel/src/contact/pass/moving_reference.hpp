// Surfaces that move, scalar: written by hand beside moving.inl.hpp, the same letters in the same order of operations.
#pragma once

#include <array>
#include <cstddef>

#include "contact/surfaces/shape_reference.hpp"
#include "contact/surfaces/surface.hpp"
#include "simd/particle.hpp"

namespace dvdx::reference {

template <Arithmetic arithmetic, class T>
Vector<T> cross_product(const Vector<T>& a, const Vector<T>& b) noexcept {
  return {subtract_product<arithmetic>(a[1] * b[2], a[2], b[1]), subtract_product<arithmetic>(a[2] * b[0], a[0], b[2]),
          subtract_product<arithmetic>(a[0] * b[1], a[1], b[0])};
}

template <Arithmetic arithmetic, class T>
T by_powers(const std::array<T, 7>& terms, T x) noexcept {
  T sum = terms[6];
  for (std::size_t n = 6; n-- > 0;) sum = multiply_add<arithmetic>(sum, x, terms[n]);
  return sum;
}

// Returns r turned by the rotation vector w.
template <Arithmetic arithmetic, class T>
Vector<T> turned_by(const Vector<T>& w, const Vector<T>& r) noexcept {
  const T square = dot<arithmetic>(w, w);
  const T a = by_powers<arithmetic>(turn_sine<T>, square);
  const T b = by_powers<arithmetic>(turn_versine<T>, square);
  const Vector<T> once = cross_product<arithmetic>(w, r);
  const Vector<T> twice = cross_product<arithmetic>(w, once);
  Vector<T> to;
  for (std::size_t k = 0; k < 3; ++k) to[k] = multiply_add<arithmetic>(b, twice[k], multiply_add<arithmetic>(a, once[k], r[k]));
  return to;
}

template <class T>
Vector<T> scaled_by(T s, const Vector<T>& a) noexcept {
  return {s * a[0], s * a[1], s * a[2]};
}

// Returns the vector from the point `at` of the axis to x, at the time t before the end.
template <Arithmetic arithmetic, class T>
Vector<T> arm_of(const Surface<T>& surface, const Vector<T>& x, T t) noexcept {
  Vector<T> arm;
  for (std::size_t k = 0; k < 3; ++k) arm[k] = multiply_add<arithmetic>(t, surface.u[k], x[k]) - surface.at[k];
  return arm;
}

// Returns the velocity of the surface at x, at the time t before the end.
template <Arithmetic arithmetic, class T>
Vector<T> velocity_at(const Surface<T>& surface, const Vector<T>& x, T t) noexcept {
  if (surface.movement != Movement::turns) return surface.u;
  const Vector<T> turn = cross_product<arithmetic>(surface.omega, arm_of<arithmetic>(surface, x, t));
  return {surface.u[0] + turn[0], surface.u[1] + turn[1], surface.u[2] + turn[2]};
}

// Returns where a surface carries a point that is at x at the time t before the end.
template <Arithmetic arithmetic, class T>
Vector<T> taken_along(const Surface<T>& surface, const Vector<T>& x, T t) noexcept {
  Vector<T> to;
  if (surface.movement != Movement::turns) {
    for (std::size_t k = 0; k < 3; ++k) to[k] = multiply_add<arithmetic>(t, surface.u[k], x[k]);
    return to;
  }
  const Vector<T> arm = turned_by<arithmetic>(scaled_by(t, surface.omega), arm_of<arithmetic>(surface, x, t));
  for (std::size_t k = 0; k < 3; ++k) to[k] = surface.at[k] + arm[k];
  return to;
}

template <Arithmetic arithmetic, class T>
Particle<T> seen_from(const Surface<T>& surface, const Particle<T>& p, T t) noexcept {
  if (surface.movement == Movement::rest) return p;
  Particle<T> seen = p;
  seen.x0 = taken_along<arithmetic>(surface, p.x0, t);
  seen.v0 = difference(p.v0, velocity_at<arithmetic>(surface, p.x0, t));
  if (surface.movement == Movement::turns) seen.v0 = turned_by<arithmetic>(scaled_by(t, surface.omega), seen.v0);
  seen.v1 = difference(p.v1, velocity_at<arithmetic>(surface, p.x1, T(0)));
  return seen;
}

// l and q of a bent path (surface.hpp), both 0 at rest.
template <class T>
struct Slip {
  bool is_there = false;
  Vector<T> l{}, q{};
};

template <class T>
Slip<T> slip_of(const Surface<T>& surface, const Particle<T>& p, const Particle<T>& seen, T t) noexcept {
  Slip<T> slip;
  slip.is_there = surface.movement != Movement::rest;
  if (!slip.is_there) return slip;
  slip.l = scaled_by(t, difference(seen.v0, p.v0));
  if (surface.movement == Movement::turns) {
    slip.q = difference(difference(difference(seen.x1, seen.x0), difference(p.x1, p.x0)), slip.l);
  }
  return slip;
}

}  // namespace dvdx::reference
