// Whether particles that stand still stay so, scalar. There is no wide body: few particles of a block stand still.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "contact/pass/push_out_reference.hpp"
#include "contact/pass/stay.hpp"

namespace dvdx::reference {

// Whether a surface has the velocity V at x, t before the end of the flow, to rounding: two flows or surfaces may differ by it.
template <Arithmetic arithmetic, class T>
bool moves_with(const Surface<T>& surface, const Vector<T>& x, T t, const Vector<T>& V) noexcept {
  if (surface.movement == Movement::rest) return V == Vector<T>{};
  const Vector<T> own = velocity_at<arithmetic>(surface, x, t);
  T size = one_norm(own) + one_norm(V);
  if (surface.movement == Movement::turns) size = size + one_norm(surface.omega) * (one_norm(x) + one_norm(surface.at));
  return one_norm(difference(own, V)) <= 8 * std::numeric_limits<T>::epsilon() * size;
}

template <Arithmetic arithmetic, class T>
bool stands_on(const Surface<T>& surface, const Vector<T>& x, T s) noexcept {
  const T roundings = surface.movement == Movement::rest ? 8 : 32;
  return std::abs(s) <= roundings * std::numeric_limits<T>::epsilon() * (one_norm(x) + surface.radius);
}

// Returns, of the surfaces at x that move by V there, the one with the least n.v below `most`. stands: receives any of them.
template <Arithmetic arithmetic, class T>
Holder<T> most_pressed(const Terms<T>& terms, const Vector<T>& x, const Vector<T>& V, const Vector<T>& v, const Vector<T>& P,
                       const Supports<T>& held, T most, std::uint32_t& stands) noexcept {
  Holder<T> found;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    if (held.has(j) || !moves_with<arithmetic>(surface, x, T(0), V)) continue;
    const Touch<T> at = touch<arithmetic>(surface, x);
    if (!stands_on<arithmetic>(surface, x, at.s)) continue;
    stands = static_cast<std::uint32_t>(j);
    const T out = dot<arithmetic>(at.n, v);
    if (!(out < most)) continue;
    most = out;
    found = {.number = j, .s = dot<arithmetic>(at.n, P), .mu = surface.mu, .hold = surface.hold, .n = at.n};
  }
  return found;
}

// Returns the surface that P presses most if nothing of P is left, or no_surface. Asked::stands: any surface it stands on.
template <Arithmetic arithmetic, class T>
std::uint32_t carried_by(const Terms<T>& terms, const Vector<T>& x, const Vector<T>& V, const Vector<T>& P,
                         Asked asked) noexcept {
  constexpr std::size_t none = Supports<T>::none;
  std::uint32_t stands = no_surface;
  Supports<T> held;
  const Holder<T> a = most_pressed<arithmetic>(terms, x, V, P, P, held, T(0), stands);
  if (asked == Asked::stands) return stands;
  if (a.number == none) return no_surface;
  const auto most = static_cast<std::uint32_t>(a.number);
  // The impulse stands for both the way and the velocity that surfaces take back.
  const Particle<T> pressed{.x0 = {}, .v0 = P, .x1 = P, .v1 = P};
  const T rounding = -2 * std::numeric_limits<T>::epsilon() * one_norm(P);
  HeldEnd<T> end = held_by_one<arithmetic>(a, pressed, T(1));
  held.a = a.number;
  const Holder<T> b = most_pressed<arithmetic>(terms, x, V, end.v, P, held, rounding, stands);
  if (b.number != none) {
    end = held_by_two<arithmetic>(a, b, pressed, T(1));
    held.b = b.number;
    const Holder<T> c = most_pressed<arithmetic>(terms, x, V, end.v, P, held, rounding, stands);
    if (c.number != none) end = held_by_three<arithmetic>(a, b, c, pressed, T(1));
  }
  const T length = std::sqrt(dot<arithmetic>(end.v, end.v));
  return length == 0 || kept_by_friction(end.slide, end.hold, length) == 0 ? most : no_surface;
}

template <Arithmetic arithmetic, class T>
bool is_pushed_out(const Terms<T>& terms, const Vector<T>& x, T t) noexcept {
  const auto pushes = [&](const Surface<T>& surface) {
    return pushes_out(surface) && start_on<arithmetic>(surface, x, t).is_inside;
  };
  return std::any_of(terms.surfaces, terms.surfaces + terms.surface_count, pushes);
}

template <Arithmetic arithmetic, class T>
std::uint32_t stays(const Terms<T>& terms, const SubstepImpulse<T>& impulse, std::size_t carrier, Particle<T>& p) noexcept {
  const bool moves = carrier < terms.surface_count && terms.surfaces[carrier].movement != Movement::rest;
  const Vector<T> x = moves ? taken_along<arithmetic>(terms.surfaces[carrier], p.x0, impulse.t) : p.x0;
  const Vector<T> V = moves ? velocity_at<arithmetic>(terms.surfaces[carrier], x, T(0)) : Vector<T>{};
  Vector<T> P;
  for (std::size_t k = 0; k < 3; ++k) P[k] = impulse.pulses * (p.v0[k] - V[k]) + impulse.flows * p.v1[k];
  const std::uint32_t by = carried_by<arithmetic>(terms, x, V, P, impulse.pulses == 0 ? Asked::stands : Asked::stays);
  if (by == no_surface || (terms.pushes && is_pushed_out<arithmetic>(terms, p.x0, impulse.t))) return no_surface;
  p.x1 = x;
  p.v1 = V;
  return by;
}

template <Arithmetic arithmetic, class T>
std::uint32_t carrier(const Terms<T>& terms, std::span<const std::uint32_t> movers, T t, const Vector<T>& x,
                      const Vector<T>& v) noexcept {
  const auto goes = [&](std::uint32_t j) { return j != no_surface && moves_with<arithmetic>(terms.surfaces[j], x, t, v); };
  if (std::none_of(movers.begin(), movers.end(), goes)) return no_surface;
  for (std::uint32_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    if (surface.movement == Movement::rest || !goes(j)) continue;
    const Vector<T> there = taken_along<arithmetic>(surface, x, t);
    if (stands_on<arithmetic>(surface, there, touch<arithmetic>(surface, there).s)) return j;
  }
  return no_surface;
}

}  // namespace dvdx::reference
