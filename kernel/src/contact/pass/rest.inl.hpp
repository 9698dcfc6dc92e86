// Lanes that surfaces hold, with friction, wide. The scalar twin: rest_reference.hpp.
#pragma once

#include <cstddef>
#include <limits>

#include "contact/pass/impact_state.inl.hpp"

namespace dvdx {
namespace {

// Returns the part of a tangential velocity that friction leaves. Friction takes `slide` off it; up to `hold` it vanishes.
template <class V>
V kept_by_friction(V slide, V hold, V length) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const V kept = select<V>(hold >= length, zero, one - quotient<V>(slide, length));
  return select<V>(hold > zero, kept, one);
}

// A surface that holds lanes: its index (-1: none), its normal and distance s at the end of the step if nothing held them, the
// distance s0 at the start, its friction.
template <class V>
struct Holder {
  V number, s, s0, mu, hold;
  Three<V> n;
};

template <class V>
Holder<V> no_holder() noexcept {
  const V zero(Scalar<V>(0));
  return {V(Scalar<V>(-1)), zero, zero, zero, zero, three<V>(zero)};
}

template <class V>
Holder<V> select(const Mask<V>& where, const Holder<V>& a, const Holder<V>& b) noexcept {
  return {select<V>(where, a.number, b.number), select<V>(where, a.s, b.s),       select<V>(where, a.s0, b.s0),
          select<V>(where, a.mu, b.mu),         select<V>(where, a.hold, b.hold), select(where, a.n, b.n)};
}

template <class V>
Mask<V> is_among(const Supports<V>& held, V number) noexcept {
  return (held.a == number) | (held.b == number) | (held.c == number);
}

// The surfaces that may hold lanes from here on. Lanes must stand on the surface, and neither leave it higher than rounding nor
// come faster than forces and the surfaces that already hold them can stop within the step.
// A lane that slides into the edge of two planes without restitution goes up the other plane and comes back, again and again,
// each time with kappa times its speed, kappa the product of the normals. This ends after 1/(1 - kappa) times the first way
// there and back, which takes d0/(-c) of the step.
template <class V, Arithmetic arithmetic, PathForm form, SurfaceMix mix>
class Candidates {
  using T = Scalar<V>;

 public:
  Candidates(const Terms<T>& terms, const Trajectory<V>& m, const ImpactState<V, arithmetic, form>& state) noexcept
      : end_size(one_norm(m.x1)), terms_(terms), m_(m), state_(state), size_(one_norm(m.x0)) {}

  struct Candidate {
    Mask<V> may_hold;
    V s0;  // the distance at the start
  };

  // s1: the distance at the end, as lanes are held so far; part: the part of the step within which leaving lanes must return.
  [[nodiscard]] Candidate of(std::size_t j, V s1, V part) const noexcept {
    const Surface<T>& surface = terms_.surfaces[j];
    if constexpr (mix == SurfaceMix::planes) return look(j, s1, part, m_, size_);
    Trajectory<V> room;
    const Trajectory<V>& m = seen_from<V, arithmetic>(surface, m_, state_.t, room);
    return look(j, s1, part, m, surface.movement == Movement::rest ? size_ : one_norm(m.x0));
  }

  V end_size;  // the sum of the end's coordinates

 private:
  [[nodiscard]] [[gnu::always_inline]] inline Candidate look(std::size_t j, V s1, V part, const Trajectory<V>& m,
                                                             V size) const noexcept {
    const Surface<T>& surface = terms_.surfaces[j];
    const Touch<V> start = touch<V, arithmetic, mix>(surface, m.x0);
    const V low = V(4 * low_bounce * std::numeric_limits<T>::epsilon()) * size;
    const T roundings = surface.movement == Movement::rest ? T(2) : T(8);
    const V near = V(roundings * std::numeric_limits<T>::epsilon()) * ((size + end_size) + V(surface.radius + surface.radius));
    const V d0 = state_.t * dot<arithmetic>(start.n, m.v0);
    const V c = s1 - d0;
    const Mask<V> is_last = state_.last == V(static_cast<T>(j));
    const Mask<V> has_hit = is_last & Mask<V>(has_pulses(surface));
    const Mask<V> stands = has_hit | ((start.s >= V(T(-0.5)) * near) & (is_last | (start.s <= near)));
    const Mask<V> leaves = d0 > V(T(0));
    const Mask<V> stays_low = (d0 * d0 <= -(low * c)) | (d0 <= part * -c);
    const Mask<V> comes_slow = (-d0 <= -(c + c)) & (V(surface.e) * -d0 <= V(T(1) - surface.e) * -c);
    return {stands & ((leaves & stays_low) | ((!leaves) & comes_slow)), start.s};
  }

  const Terms<T>& terms_;
  const Trajectory<V>& m_;
  const ImpactState<V, arithmetic, form>& state_;
  V size_;
};

// The multiples of two normals, whose product is kappa, that bring the distances (or velocities) a and b to 0. Neither is
// negative, and one is 0 if the other suffices.
template <class V>
struct Two {
  V a, b;
};

// Two normals: kappa is their product, scale 1/(1 - kappa^2) unless they are parallel.
template <class V>
struct Wedge {
  V kappa, scale;
  Mask<V> is_wedge;
};

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline Wedge<V> wedge_of(const Three<V>& a, const Three<V>& b) noexcept {
  using T = Scalar<V>;
  const V one(T(1));
  const V kappa = dot<arithmetic>(a, b);
  const V det = subtract_product<arithmetic>(one, kappa, kappa);
  const Mask<V> is_wedge = det > V(64 * std::numeric_limits<T>::epsilon());
  return {kappa, quotient<V>(one, select<V>(is_wedge, det, one)), is_wedge};
}

template <class V>
[[gnu::always_inline]] inline Two<V> solve_two(V a, V b, const Wedge<V>& wedge) noexcept {
  const V zero(Scalar<V>(0));
  const V both_a = wedge.scale * (wedge.kappa * b - a);
  const V both_b = wedge.scale * (wedge.kappa * a - b);
  const V alone_a = select<V>(a < zero, negative(a), zero);
  const V alone_b = select<V>(b < zero, negative(b), zero);
  const Mask<V> only_b = wedge.is_wedge & (both_a < zero);
  const Mask<V> only_a = (!wedge.is_wedge) | ((!only_b) & (both_b < zero));
  return {select<V>(only_b, zero, select<V>(only_a, alone_a, both_a)),
          select<V>(only_b, alone_b, select<V>(only_a, zero, both_b))};
}

// The end of lanes that are held: the place x, the velocity v along the surfaces before friction takes `slide` off it (up to
// `hold` all of it), and the velocity v0 along them at the start.
template <class V>
struct HeldEnd {
  Three<V> x, v, v0;
  V slide, hold;
};

template <class V>
HeldEnd<V> select(const Mask<V>& where, const HeldEnd<V>& a, const HeldEnd<V>& b) noexcept {
  return {select(where, a.x, b.x), select(where, a.v, b.v), select(where, a.v0, b.v0), select<V>(where, a.slide, b.slide),
          select<V>(where, a.hold, b.hold)};
}

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline HeldEnd<V> held_by_one(const Holder<V>& a, const Trajectory<V>& m, V direction) noexcept {
  const V zero(Scalar<V>(0));
  const V vn = dot<arithmetic>(a.n, m.v1);
  const Mask<V> is_pressed = direction * vn < zero;
  const V removed = select<V>(is_pressed, magnitude(vn), zero);
  const V vn0 = dot<arithmetic>(a.n, m.v0);
  return {subtract_product<arithmetic>(m.x1, a.s, a.n), select(is_pressed, subtract_product<arithmetic>(m.v1, vn, a.n), m.v1),
          select(direction * vn0 < zero, subtract_product<arithmetic>(m.v0, vn0, a.n), m.v0), a.mu * removed, a.hold * removed};
}

template <class V, Arithmetic arithmetic>
[[gnu::always_inline]] inline HeldEnd<V> held_by_two(const Holder<V>& a, const Holder<V>& b, const Trajectory<V>& m,
                                                     V direction) noexcept {
  const Wedge<V> wedge = wedge_of<V, arithmetic>(a.n, b.n);
  const Two<V> way = solve_two(a.s, b.s, wedge);
  const auto along_both = [&](const Three<V>& v, const Two<V>& removed) {
    return multiply_add<arithmetic>(direction * removed.b, b.n, multiply_add<arithmetic>(direction * removed.a, a.n, v));
  };
  const auto pressures = [&](const Three<V>& v) {
    return solve_two(direction * dot<arithmetic>(a.n, v), direction * dot<arithmetic>(b.n, v), wedge);
  };
  const Two<V> removed = pressures(m.v1);
  return {multiply_add<arithmetic>(way.b, b.n, multiply_add<arithmetic>(way.a, a.n, m.x1)), along_both(m.v1, removed),
          along_both(m.v0, pressures(m.v0)), multiply_add<arithmetic>(b.mu, removed.b, a.mu * removed.a),
          multiply_add<arithmetic>(b.hold, removed.b, a.hold * removed.a)};
}

// Returns the surface inside which the lanes' end x lies deepest, among those that may hold lanes, with its normal and distance
// at x1, the end if nothing held them. first: the only surface that holds lanes so far, or null.
template <class V, Arithmetic arithmetic, PathForm form, SurfaceMix mix>
Holder<V> deepest(const Terms<Scalar<V>>& terms, const Candidates<V, arithmetic, form, mix>& candidates, const Three<V>& x1,
                  const Supports<V>& held, const Holder<V>* first, const Three<V>& x, Mask<V> lanes) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  Holder<V> found = no_holder<V>();
  V depth = V(-2 * std::numeric_limits<T>::epsilon()) * candidates.end_size;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const V number(static_cast<T>(j));
    const V s = touch<V, arithmetic, mix>(surface, x).s;
    const Mask<V> is_new = lanes & (s < depth) & !is_among(held, number);
    if (!any_lane<V>(is_new)) continue;
    const Touch<V> end = touch<V, arithmetic, mix>(surface, x1);
    V part = zero;
    if (first != nullptr && surface.e == 0) {
      const V over = one - dot<arithmetic>(first->n, end.n);
      part = select<V>(over < one, over, one);
    }
    const auto candidate = candidates.of(j, s, part);
    const Mask<V> is_it = is_new & candidate.may_hold;
    depth = select<V>(is_it, s, depth);
    found = select(is_it, Holder<V>{number, end.s, candidate.s0, V(surface.mu), V(surface.hold), end.n}, found);
  }
  return found;
}

// A third surface keeps lanes from moving along the edge of two. Two of the three may suffice; otherwise lanes do not move.
template <class V, Arithmetic arithmetic>
HeldEnd<V> held_by_three(const Holder<V>& a, const Holder<V>& b, const Holder<V>& c, const Trajectory<V>& m,
                         V direction) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V depth = V(-2 * std::numeric_limits<T>::epsilon()) * one_norm(m.x1);
  const auto leaves = [&](const Holder<V>& first, const Holder<V>& other) {
    const Two<V> way = solve_two(first.s, c.s, wedge_of<V, arithmetic>(first.n, c.n));
    const V s = multiply_add<arithmetic>(way.b, dot<arithmetic>(c.n, other.n),
                                         multiply_add<arithmetic>(way.a, dot<arithmetic>(first.n, other.n), other.s));
    return s >= depth;
  };
  const Mask<V> leaves_b = leaves(a, b);
  const Mask<V> leaves_a = leaves(b, a);
  const HeldEnd<V> end = held_by_two<V, arithmetic>(select(leaves_b, a, b), c, m, direction);
  return select(leaves_b | leaves_a, end, HeldEnd<V>{m.x0, three<V>(zero), three<V>(zero), zero, zero});
}

// Lanes as seen from the surfaces that hold them. v: the velocity of the surfaces at the lanes' end before the hold; more: the
// part of v that is not the first surface's.
template <class V>
struct SeenByHolders {
  Trajectory<V> m;
  Three<V> v, more;
};

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] SeenByHolders<V> against_one(const Terms<Scalar<V>>& terms, const Holder<V>& a, const Trajectory<V>& m,
                                               V t) noexcept {
  using T = Scalar<V>;
  const Three<V> none = three<V>(V(T(0)));
  SeenByHolders<V> against{m, none, none};
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const Mask<V> is_it = a.number == V(static_cast<T>(j));
    if (surface.movement == Movement::rest || !any_lane<V>(is_it)) continue;
    const Trajectory<V> seen = as_seen<V, arithmetic>(surface, m, t);
    const Three<V> v = velocity_at<V, arithmetic>(surface, m.x1, V(T(0)));
    against.m.x0 = select(is_it, seen.x0, against.m.x0);
    against.m.v0 = select(is_it, seen.v0, against.m.v0);
    against.v = select(is_it, v, against.v);
  }
  against.m.v1 = m.v1 - against.v;
  return against;
}

template <class V, Arithmetic arithmetic>
[[gnu::noinline]] SeenByHolders<V> against_two(const Terms<Scalar<V>>& terms, const Holder<V>& a, const Holder<V>& b,
                                               const Trajectory<V>& m, V t) noexcept {
  const SeenByHolders<V> one = against_one<V, arithmetic>(terms, a, m, t);
  const Three<V> other = against_one<V, arithmetic>(terms, b, m, t).v;
  const Wedge<V> wedge = wedge_of<V, arithmetic>(a.n, b.n);
  const V share = select<V>(wedge.is_wedge, wedge.scale * dot<arithmetic>(b.n, other - one.v), V(Scalar<V>(0)));
  const Three<V> more = share * subtract_product<arithmetic>(b.n, wedge.kappa, a.n);
  SeenByHolders<V> against = one;
  against.v = one.v + more;
  against.more = more;
  against.m.x0 = multiply_add<arithmetic>(t, more, one.m.x0);
  against.m.v0 = one.m.v0 - more;
  against.m.v1 = m.v1 - against.v;
  return against;
}

template <class V>
SeenByHolders<V> select(const Mask<V>& where, const SeenByHolders<V>& a, const SeenByHolders<V>& b) noexcept {
  return {{select(where, a.m.x0, b.m.x0), select(where, a.m.v0, b.m.v0), select(where, a.m.x1, b.m.x1),
           select(where, a.m.v1, b.m.v1)},
          select(where, a.v, b.v),
          select(where, a.more, b.more)};
}

// Returns the velocity at x of the surfaces that hold the lanes that end there.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Three<V> velocity_of(const Terms<Scalar<V>>& terms, const Holder<V>& a, const SeenByHolders<V>& against,
                                       const Three<V>& x) noexcept {
  using T = Scalar<V>;
  Three<V> v = against.v;
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const Mask<V> is_it = a.number == V(static_cast<T>(j));
    if (surface.movement != Movement::turns || !any_lane<V>(is_it)) continue;
    v = select(is_it, velocity_at<V, arithmetic>(surface, x, V(T(0))) + against.more, v);
  }
  return v;
}

// Whether the first surface that holds lanes moves.
template <class V>
[[gnu::noinline]] Mask<V> is_carried(const Terms<Scalar<V>>& terms, const Holder<V>& a) noexcept {
  Mask<V> is_it(false);
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    if (terms.surfaces[j].movement != Movement::rest) is_it = is_it | (a.number == V(static_cast<Scalar<V>>(j)));
  }
  return is_it;
}

// Puts lanes that rest on two moving surfaces back onto both. Rounding would otherwise lead them off, step by step.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] Three<V> onto_both(const Holder<V>& a, const Holder<V>& b, const Three<V>& x0) noexcept {
  const Wedge<V> wedge = wedge_of<V, arithmetic>(a.n, b.n);
  const V by_a = wedge.scale * (wedge.kappa * b.s0 - a.s0);
  const V by_b = wedge.scale * (wedge.kappa * a.s0 - b.s0);
  return select(wedge.is_wedge, multiply_add<arithmetic>(by_b, b.n, multiply_add<arithmetic>(by_a, a.n, x0)), x0);
}

// Moves ends, which friction has put along tangent planes, back onto a curved surface, and removes their normal velocity.
template <class V, Arithmetic arithmetic>
[[gnu::noinline]] void follow(const Terms<Scalar<V>>& terms, const Holder<V>& a, Mask<V> lanes, HeldEnd<V>& end) noexcept {
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<Scalar<V>>& surface = terms.surfaces[j];
    const Mask<V> is_it = lanes & (a.number == V(static_cast<Scalar<V>>(j)));
    if (surface.shape == Shape::plane || !any_lane<V>(is_it)) continue;
    const Touch<V> there = touch<V, arithmetic>(surface, end.x);
    const V vn = dot<arithmetic>(there.n, end.v);
    end.x = select(is_it, subtract_product<arithmetic>(end.x, there.s, there.n), end.x);
    end.v = select(is_it, subtract_product<arithmetic>(end.v, vn, there.n), end.v);
  }
}

// Ends the step of lanes on the surfaces that hold them from here on: an active set of at most three, the deepest first.
template <class V, Arithmetic arithmetic, PathForm form, SurfaceMix mix = SurfaceMix::any>
void hold(const Terms<Scalar<V>>& terms, Trajectory<V>& m, ImpactState<V, arithmetic, form>& state, Mask<V> lanes) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V none(T(-1));
  constexpr bool is_any = mix == SurfaceMix::any;
  if constexpr (is_any) watch(terms, state, m.x1, lanes);
  const Candidates<V, arithmetic, form, mix> candidates(terms, m, state);
  Holder<V> a = no_holder<V>();
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    const V number(static_cast<T>(j));
    const Touch<V> end = touch<V, arithmetic, mix>(surface, m.x1);
    const Mask<V> is_deeper = lanes & (end.s < a.s);
    if (!any_lane<V>(is_deeper)) continue;
    const auto candidate = candidates.of(j, end.s, zero);
    a = select(is_deeper & candidate.may_hold, Holder<V>{number, end.s, candidate.s0, V(surface.mu), V(surface.hold), end.n},
               a);
  }
  const Mask<V> is_held = a.number >= zero;
  auto& held = state.supports;
  held.a = select<V>(lanes, a.number, held.a);
  held.b = select<V>(lanes, none, held.b);
  held.c = select<V>(lanes, none, held.c);
  if (!any_lane<V>(is_held)) return;

  const bool moves = is_any && terms.moves;
  SeenByHolders<V> moved;
  if (moves) moved = against_one<V, arithmetic>(terms, a, m, state.t);
  const auto against = [&]() -> const Trajectory<V>& { return moves ? moved.m : m; };
  HeldEnd<V> end = held_by_one<V, arithmetic>(a, against(), state.direction);
  if constexpr (is_any) watch(terms, state, end.x, is_held);
  const Holder<V> b = deepest<V, arithmetic, form, mix>(terms, candidates, m.x1, held, &a, end.x, is_held);
  const Mask<V> has_b = b.number >= zero;
  if (any_lane<V>(has_b)) {
    if (moves) moved = select(has_b, against_two<V, arithmetic>(terms, a, b, m, state.t), moved);
    end = select(has_b, held_by_two<V, arithmetic>(a, b, against(), state.direction), end);
    held.b = select<V>(has_b, b.number, held.b);
    if constexpr (is_any) watch(terms, state, end.x, has_b);
    const Holder<V> c = deepest<V, arithmetic, form, mix>(terms, candidates, m.x1, held, nullptr, end.x, has_b);
    const Mask<V> has_c = c.number >= zero;
    if (any_lane<V>(has_c)) {
      end = select(has_c, held_by_three<V, arithmetic>(a, b, c, against(), state.direction), end);
      held.c = select<V>(has_c, c.number, held.c);
    }
  }
  // Friction brakes all through the step.
  const V kept = kept_by_friction(end.slide, end.hold, square_root(dot<arithmetic>(end.v, end.v)));
  const Three<V> rubbed = kept * end.v;
  end.x = multiply_add<arithmetic>(V(T(0.5)) * state.t, rubbed - end.v, end.x);
  end.v = rubbed;
  if constexpr (is_any) {
    const Mask<V> slides = is_held & (held.b < zero) & (kept != V(T(1)));
    if (any_lane<V>(slides)) follow<V, arithmetic>(terms, a, slides, end);
  }

  // Rounding alone must not make a resting particle creep.
  const V motion = magnitude(state.t) * one_norm(end.v0 + end.v);
  Mask<V> rests = motion < V(std::numeric_limits<T>::epsilon() / 4) * candidates.end_size;
  if (is_any && state.leaving != nullptr) rests = rests & !state.leaving->lanes;
  const V sunk = select<V>(held.b < zero, a.s0, zero);
  end.x = select(rests, subtract_product<arithmetic>(against().x0, sunk, a.n), end.x);
  if (moves) end.x = select(rests & has_b & is_carried(terms, a), onto_both<V, arithmetic>(a, b, against().x0), end.x);
  if (moves) {
    end.v = end.v + velocity_of<V, arithmetic>(terms, a, moved, end.x);
    end.v0 = m.v0 + (end.v0 - moved.m.v0);
  }
  held.dx = select(is_held, end.x - m.x1, held.dx);
  held.dv = select(is_held, end.v - m.v1, held.dv);
  m.x1 = select(is_held, end.x, m.x1);
  m.v1 = select(is_held, end.v, m.v1);
  m.v0 = select(is_held, end.v0, m.v0);
}

}  // namespace
}  // namespace dvdx
