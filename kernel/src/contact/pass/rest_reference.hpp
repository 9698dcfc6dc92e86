// Particles that surfaces hold, with friction, scalar: written by hand beside rest.inl.hpp.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

#include "contact/pass/impact_state_reference.hpp"

namespace dvdx::reference {

template <class T>
T kept_by_friction(T slide, T hold, T length) noexcept {
  if (!(hold > 0)) return 1;
  if (hold >= length) return 0;
  return 1 - slide / length;
}

template <class T>
struct Holder {
  std::size_t number = Supports<T>::none;
  T s = 0, s0 = 0, mu = 0, hold = 0;
  Vector<T> n{};
  Vector<T> x0{}, v0{};  // the start as the surface sees it
  Vector<T> V{};         // the surface's velocity at the end
};

template <Arithmetic arithmetic, class T>
Holder<T> holder_of(std::size_t number, const Surface<T>& surface, T s, T s0, const Vector<T>& n, const Particle<T>& p,
                    const Particle<T>& seen) noexcept {
  Holder<T> holder{
      .number = number, .s = s, .s0 = s0, .mu = surface.mu, .hold = surface.hold, .n = n, .x0 = seen.x0, .v0 = seen.v0};
  if (surface.movement != Movement::rest) holder.V = velocity_at<arithmetic>(surface, p.x1, T(0));
  return holder;
}

// s1: the distance at the end, as the particle is held so far; part: the part of the step within which one that leaves must
// return. s0 receives the distance at the start.
template <Arithmetic arithmetic, PathForm form, class T>
bool may_hold(const Surface<T>& surface, T s1, T part, const Particle<T>& p, const ImpactState<arithmetic, form, T>& state,
              bool is_last, T& s0) noexcept {
  constexpr T eps = std::numeric_limits<T>::epsilon();
  const Touch<T> start = touch<arithmetic>(surface, p.x0);
  const T low = 4 * low_bounce * eps * one_norm(p.x0);
  const T roundings = surface.movement == Movement::rest ? 2 : 8;
  const T near = roundings * eps * ((one_norm(p.x0) + one_norm(p.x1)) + (surface.radius + surface.radius));
  const T d0 = state.t * dot<arithmetic>(start.n, p.v0);
  const T c = s1 - d0;
  const bool has_hit = is_last && has_pulses(surface);
  s0 = start.s;
  if (!(has_hit || (s0 >= T(-0.5) * near && (is_last || s0 <= near)))) return false;
  if (d0 > 0) return d0 * d0 <= -(low * c) || d0 <= part * -c;
  return -d0 <= -(c + c) && surface.e * -d0 <= (1 - surface.e) * -c;
}

template <class T>
struct Two {
  T a, b;
};

template <Arithmetic arithmetic, class T>
Two<T> solve_two(T a, T b, T kappa) noexcept {
  const T det = subtract_product<arithmetic>(T(1), kappa, kappa);
  const T alone_a = a < 0 ? -a : T(0);
  const T alone_b = b < 0 ? -b : T(0);
  if (!(det > 64 * std::numeric_limits<T>::epsilon())) return {alone_a, 0};
  const T scale = 1 / det;
  const T both_a = scale * (kappa * b - a);
  const T both_b = scale * (kappa * a - b);
  if (both_a < 0) return {0, alone_b};
  if (both_b < 0) return {alone_a, 0};
  return {both_a, both_b};
}

template <class T>
struct HeldEnd {
  Vector<T> x{}, v{}, v0{};
  T slide = 0, hold = 0;
  std::array<T, 3> removed{};  // of the end's velocity, by each surface along its normal
};

template <Arithmetic arithmetic, class T>
HeldEnd<T> held_by_one(const Holder<T>& a, const Particle<T>& p, T direction) noexcept {
  const T vn = dot<arithmetic>(a.n, p.v1);
  const bool is_pressed = direction * vn < 0;
  const T removed = is_pressed ? std::abs(vn) : T(0);
  const T vn0 = dot<arithmetic>(a.n, p.v0);
  HeldEnd<T> end{.x = {}, .v = p.v1, .v0 = p.v0, .slide = a.mu * removed, .hold = a.hold * removed, .removed = {removed, 0, 0}};
  for (std::size_t k = 0; k < 3; ++k) {
    end.x[k] = subtract_product<arithmetic>(p.x1[k], a.s, a.n[k]);
    if (is_pressed) end.v[k] = subtract_product<arithmetic>(p.v1[k], vn, a.n[k]);
    if (direction * vn0 < 0) end.v0[k] = subtract_product<arithmetic>(p.v0[k], vn0, a.n[k]);
  }
  return end;
}

template <Arithmetic arithmetic, class T>
HeldEnd<T> held_by_two(const Holder<T>& a, const Holder<T>& b, const Particle<T>& p, T direction) noexcept {
  const T kappa = dot<arithmetic>(a.n, b.n);
  const Two<T> way = solve_two<arithmetic>(a.s, b.s, kappa);
  const auto pressures = [&](const Vector<T>& v) {
    return solve_two<arithmetic>(direction * dot<arithmetic>(a.n, v), direction * dot<arithmetic>(b.n, v), kappa);
  };
  const Two<T> removed = pressures(p.v1);
  const Two<T> removed0 = pressures(p.v0);
  HeldEnd<T> end;
  for (std::size_t k = 0; k < 3; ++k) {
    end.x[k] = multiply_add<arithmetic>(way.b, b.n[k], multiply_add<arithmetic>(way.a, a.n[k], p.x1[k]));
    const T along_a = multiply_add<arithmetic>(direction * removed.a, a.n[k], p.v1[k]);
    end.v[k] = multiply_add<arithmetic>(direction * removed.b, b.n[k], along_a);
    const T along_a0 = multiply_add<arithmetic>(direction * removed0.a, a.n[k], p.v0[k]);
    end.v0[k] = multiply_add<arithmetic>(direction * removed0.b, b.n[k], along_a0);
  }
  end.slide = multiply_add<arithmetic>(b.mu, removed.b, a.mu * removed.a);
  end.hold = multiply_add<arithmetic>(b.hold, removed.b, a.hold * removed.a);
  end.removed = {removed.a, removed.b, 0};
  return end;
}

// A particle as seen from the surfaces that hold it. V: the velocity of the surfaces at the particle's end before the hold;
// more: the part of V that is not the first surface's.
template <class T>
struct SeenByHolders {
  Particle<T> p;
  Vector<T> V{}, more{};
};

template <class T>
SeenByHolders<T> against_one(const Terms<T>& terms, const Holder<T>& a, const Particle<T>& p) noexcept {
  if (!terms.moves) return {p};
  return {{.x0 = a.x0, .v0 = a.v0, .x1 = p.x1, .v1 = difference(p.v1, a.V)}, a.V};
}

template <Arithmetic arithmetic, class T>
SeenByHolders<T> against_two(const Terms<T>& terms, const Holder<T>& a, const Holder<T>& b, const Particle<T>& p,
                             T t) noexcept {
  if (!terms.moves) return {p};
  const T kappa = dot<arithmetic>(a.n, b.n);
  const T det = subtract_product<arithmetic>(T(1), kappa, kappa);
  const bool is_wedge = det > 64 * std::numeric_limits<T>::epsilon();
  const T share = is_wedge ? 1 / det * dot<arithmetic>(b.n, difference(b.V, a.V)) : T(0);
  SeenByHolders<T> against{{.x0 = a.x0, .v0 = a.v0, .x1 = p.x1, .v1 = p.v1}};
  for (std::size_t k = 0; k < 3; ++k) {
    const T more = share * subtract_product<arithmetic>(b.n[k], kappa, a.n[k]);
    against.V[k] = a.V[k] + more;
    against.more[k] = more;
    against.p.x0[k] = multiply_add<arithmetic>(t, more, a.x0[k]);
    against.p.v0[k] = a.v0[k] - more;
    against.p.v1[k] = p.v1[k] - against.V[k];
  }
  return against;
}

template <Arithmetic arithmetic, PathForm form, class T>
Holder<T> deepest(const Terms<T>& terms, const Particle<T>& p, const ImpactState<arithmetic, form, T>& state,
                  const Holder<T>* first, const Vector<T>& x) noexcept {
  Holder<T> found;
  T depth = -2 * std::numeric_limits<T>::epsilon() * one_norm(p.x1);
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const T s = touch<arithmetic>(surface, x).s;
    if (!(s < depth) || state.supports.has(j)) continue;
    const Touch<T> end = touch<arithmetic>(surface, p.x1);
    const Particle<T> seen = seen_from<arithmetic>(surface, p, state.t);
    T s0 = 0;
    T part = 0;
    if (first != nullptr && surface.e == 0) {
      const T over = 1 - dot<arithmetic>(first->n, end.n);
      part = over < 1 ? over : T(1);
    }
    if (!may_hold(surface, s, part, seen, state, state.last == j, s0)) continue;
    depth = s;
    found = holder_of<arithmetic>(j, surface, end.s, s0, end.n, p, seen);
  }
  return found;
}

template <Arithmetic arithmetic, class T>
HeldEnd<T> held_by_three(const Holder<T>& a, const Holder<T>& b, const Holder<T>& c, const Particle<T>& p,
                         T direction) noexcept {
  const T depth = -2 * std::numeric_limits<T>::epsilon() * one_norm(p.x1);
  const auto leaves = [&](const Holder<T>& first, const Holder<T>& other) {
    const Two<T> way = solve_two<arithmetic>(first.s, c.s, dot<arithmetic>(first.n, c.n));
    const T s = multiply_add<arithmetic>(way.b, dot<arithmetic>(c.n, other.n),
                                         multiply_add<arithmetic>(way.a, dot<arithmetic>(first.n, other.n), other.s));
    return s >= depth;
  };
  if (leaves(a, b)) {
    HeldEnd<T> end = held_by_two<arithmetic>(a, c, p, direction);
    end.removed = {end.removed[0], 0, end.removed[1]};
    return end;
  }
  if (leaves(b, a)) {
    HeldEnd<T> end = held_by_two<arithmetic>(b, c, p, direction);
    end.removed = {0, end.removed[0], end.removed[1]};
    return end;
  }
  return {.x = p.x0};
}

// Records the effect of each surface on the particle, which ends at p: its normal pulse, and its share of the friction.
template <Arithmetic arithmetic, PathForm form, class T>
void record_hold(const std::array<const Holder<T>*, 3>& holders, const HeldEnd<T>& end, const Vector<T>& friction,
                 const Particle<T>& p, const ImpactState<arithmetic, form, T>& state) noexcept {
  const Vector<T>& dv = state.supports.dv;
  std::array<T, 3> removed = end.removed;
  if (holders[2]->number != Supports<T>::none && removed == std::array<T, 3>{}) {
    removed = multiples(holders[0]->n, holders[1]->n, holders[2]->n, scaled_by(state.direction, dv));
  }
  std::size_t main = 0;
  while (main < 2 && !(removed[main] > 0)) ++main;
  if (!(removed[main] > 0)) main = 0;
  std::array<Vector<T>, 3> shares{};
  shares[main] = dv;
  for (std::size_t k = 0; k < 3; ++k) {
    if (k == main || !(removed[k] > 0)) continue;
    const T part = end.slide > 0 ? (holders[k]->mu * removed[k]) / end.slide : T(0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      shares[k][axis] = (state.direction * removed[k]) * holders[k]->n[axis] + part * friction[axis];
      shares[main][axis] = shares[main][axis] - shares[k][axis];
    }
  }
  // Springs and drag act on the velocity that a holding force gives, so its impulse is larger than what is left at the end.
  Vector<T> grown{1, 1, 1};
  if constexpr (form == PathForm::flow) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (state.end.P1[axis] != 0) grown[axis] = state.left / state.end.P1[axis];
    }
  }
  state.recording->begin_hold(p.x0, p.x1, state.t);
  for (std::size_t k = 0; k < 3; ++k) {
    if (shares[k] == Vector<T>{}) continue;
    state.recording->hold(holders[k]->number, {grown[0] * shares[k][0], grown[1] * shares[k][1], grown[2] * shares[k][2]});
  }
}

// Puts a particle that rests on two moving surfaces back onto both. Rounding would otherwise lead it off, step by step.
template <Arithmetic arithmetic, class T>
Vector<T> onto_both(const Holder<T>& a, const Holder<T>& b, const Vector<T>& x0) noexcept {
  const T kappa = dot<arithmetic>(a.n, b.n);
  const T det = subtract_product<arithmetic>(T(1), kappa, kappa);
  if (!(det > 64 * std::numeric_limits<T>::epsilon())) return x0;
  const T scale = 1 / det;
  const T by_a = scale * (kappa * b.s0 - a.s0);
  const T by_b = scale * (kappa * a.s0 - b.s0);
  Vector<T> x;
  for (std::size_t k = 0; k < 3; ++k) {
    x[k] = multiply_add<arithmetic>(by_b, b.n[k], multiply_add<arithmetic>(by_a, a.n[k], x0[k]));
  }
  return x;
}

// Moves an end, which friction has put along the tangent plane, back onto a curved surface, and removes its normal velocity.
template <Arithmetic arithmetic, class T>
void follow(const Surface<T>& surface, HeldEnd<T>& end) noexcept {
  if (surface.shape == Shape::plane) return;
  const Touch<T> there = touch<arithmetic>(surface, end.x);
  const T vn = dot<arithmetic>(there.n, end.v);
  for (std::size_t k = 0; k < 3; ++k) {
    end.x[k] = subtract_product<arithmetic>(end.x[k], there.s, there.n[k]);
    end.v[k] = subtract_product<arithmetic>(end.v[k], vn, there.n[k]);
  }
}

template <Arithmetic arithmetic, PathForm form, class T>
void hold(const Terms<T>& terms, Particle<T>& p, ImpactState<arithmetic, form, T>& state) noexcept {
  constexpr std::size_t none = Supports<T>::none;
  Holder<T> a;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const Touch<T> end = touch<arithmetic>(surface, p.x1);
    if (!(end.s < a.s)) continue;
    const Particle<T> seen = seen_from<arithmetic>(surface, p, state.t);
    T s0 = 0;
    if (!may_hold(surface, end.s, T(0), seen, state, state.last == j, s0)) continue;
    a = holder_of<arithmetic>(j, surface, end.s, s0, end.n, p, seen);
  }
  auto& held = state.supports;
  held.a = a.number;
  held.b = held.c = none;
  if (a.number == none) return;

  Holder<T> b, c;
  SeenByHolders<T> against = against_one(terms, a, p);
  HeldEnd<T> end = held_by_one<arithmetic>(a, against.p, state.direction);
  b = deepest(terms, p, state, &a, end.x);
  if (b.number != none) {
    against = against_two<arithmetic>(terms, a, b, p, state.t);
    end = held_by_two<arithmetic>(a, b, against.p, state.direction);
    held.b = b.number;
    c = deepest<arithmetic, form, T>(terms, p, state, nullptr, end.x);
    if (c.number != none) {
      end = held_by_three<arithmetic>(a, b, c, against.p, state.direction);
      held.c = c.number;
    }
  }
  const T kept = kept_by_friction(end.slide, end.hold, std::sqrt(dot<arithmetic>(end.v, end.v)));
  Vector<T> friction;
  for (std::size_t k = 0; k < 3; ++k) {
    const T rubbed = kept * end.v[k];
    friction[k] = rubbed - end.v[k];
    end.x[k] = multiply_add<arithmetic>(T(0.5) * state.t, friction[k], end.x[k]);
    end.v[k] = rubbed;
  }
  if (held.b == none && kept != 1) follow<arithmetic>(terms.surfaces[a.number], end);
  const T motion = std::abs(state.t) * one_norm(sum_of(end.v0, end.v));
  if (state.leaving == nullptr && motion < std::numeric_limits<T>::epsilon() / 4 * one_norm(p.x1)) {
    const T sunk = held.b == none ? a.s0 : T(0);
    for (std::size_t k = 0; k < 3; ++k) end.x[k] = subtract_product<arithmetic>(against.p.x0[k], sunk, a.n[k]);
    const bool is_carried = terms.surfaces[a.number].movement != Movement::rest;
    if (is_carried && held.b != none) end.x = onto_both<arithmetic>(a, b, against.p.x0);
  }
  if (terms.moves) {
    const Surface<T>& surface = terms.surfaces[a.number];
    end.v =
        sum_of(end.v, surface.movement == Movement::turns ? sum_of(velocity_at<arithmetic>(surface, end.x, T(0)), against.more)
                                                          : against.V);
    end.v0 = sum_of(p.v0, difference(end.v0, against.p.v0));
  }
  held.dx = difference(end.x, p.x1);
  held.dv = difference(end.v, p.v1);
  p.x1 = end.x;
  p.v1 = end.v;
  p.v0 = end.v0;
  if (state.recording != nullptr) record_hold({&a, &b, &c}, end, friction, p, state);
}

}  // namespace dvdx::reference
