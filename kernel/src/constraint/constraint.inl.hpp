// Constraints, wide: one in each lane. The scalar twin: constraint_reference.hpp; the derivation: constraint.hpp.
#pragma once

#include "constraint/constraint.hpp"
#include "simd/lanes.hpp"
#include "simd/three.inl.hpp"
#include "springs/network.hpp"

namespace dvdx {
namespace {

template <class V>
Three<V> gather_axes(const Axes<Scalar<V>>& columns, const std::int32_t* index) noexcept {
  return {{gather_lanes<V>(columns[0], index), gather_lanes<V>(columns[1], index), gather_lanes<V>(columns[2], index)}};
}
template <class V>
void scatter_axes(const Axes<Scalar<V>>& columns, const std::int32_t* index, const Three<V>& value) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) scatter_lanes<V>(columns[axis], index, value[axis]);
}
template <class V>
Three<V> load_axes(const Axes<Scalar<V>>& columns, std::size_t s) noexcept {
  return {{load_lanes<V>(columns[0] + s), load_lanes<V>(columns[1] + s), load_lanes<V>(columns[2] + s)}};
}
template <class V>
void store_axes(const Axes<Scalar<V>>& columns, std::size_t s, const Three<V>& value) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) store_lanes(columns[axis] + s, value[axis]);
}

// Writes only the ends that can move: constraints of one colour share the others, and other threads read those meanwhile.
template <class V>
void scatter_movable(const Axes<Scalar<V>>& columns, const std::int32_t* index, const Three<V>& value,
                     const Scalar<V>* share) noexcept {
  alignas(64) Scalar<V> lanes[3][V::size];
  for (std::size_t axis = 0; axis < 3; ++axis) store_lanes(lanes[axis], value[axis]);
  for (std::size_t k = 0; k < V::size; ++k) {
    if (share[k] == 0) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) columns[axis][index[k]] = lanes[axis][k];
  }
}

// x or v of both ends.
template <class V>
struct BothEnds {
  Three<V> a, b;
};
template <class V>
BothEnds<V> gather_ends(const PairTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& columns, std::size_t s) noexcept {
  return {gather_axes<V>(columns, terms.a + s), gather_axes<V>(columns, terms.b + s)};
}

// Moves the ends by -+ share t n where t is not 0: 0 times a bad particle's n is not 0.
template <class V, Arithmetic arithmetic>
void push_ends(const PairTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& columns, std::size_t s, const BothEnds<V>& ends, V t,
               const Three<V>& n) noexcept {
  const Mask<V> is_any = differ(t, V(Scalar<V>(0)));
  const V t_a = load_lanes<V>(terms.share_a + s) * t;
  const V t_b = load_lanes<V>(terms.share_b + s) * t;
  scatter_movable<V>(columns, terms.a + s, select(is_any, subtract_product<arithmetic>(ends.a, t_a, n), ends.a),
                     terms.share_a + s);
  scatter_movable<V>(columns, terms.b + s, select(is_any, multiply_add<arithmetic>(t_b, n, ends.b), ends.b), terms.share_b + s);
}

template <class V>
Mask<V> is_sound_square(V square) noexcept {
  return (square > V(least_square<Scalar<V>>)) & (square < V(most_square<Scalar<V>>));
}

// The sign that a sum of pulses may have: `at_most` pulls (negative), `at_least` pushes.
template <class V>
V kept_sign(V sum, bool is_pull) noexcept {
  const V zero(Scalar<V>(0));
  return select<V>(is_pull ? sum < zero : sum > zero, sum, zero);
}

template <class V>
void prepare_pairs(const PairTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, std::size_t from, std::size_t to) noexcept {
  for (std::size_t s = from; s < to; s += V::size) {
    const auto [a, b] = gather_ends<V>(terms, x, s);
    store_axes<V>(terms.n, s, b - a);
  }
}

// ---- position pulses ---------------------------------------------------------------------------------------------------

// For a bound that has not acted in this sub-step: when and in which direction it was reached.
template <class V, Arithmetic arithmetic, Bound bound>
void reach(const PairTerms<Scalar<V>>& terms, std::size_t s, const Three<V>& d, V l, V sum, Three<V>& n) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  const V dd = dot<arithmetic>(d, d);
  const V nn = dot<arithmetic>(n, n);
  const Mask<V> is_violated = bound == Bound::at_most ? dd > l * l : dd < l * l;
  const Mask<V> is_new = (sum == zero) & is_violated;
  V rate = select<V>(is_new, V(terms.per_step), load_lanes<V>(terms.rate + s));
  const Mask<V> was_free = is_new & (bound == Bound::at_most ? nn < l * l : nn > l * l);
  if (any_lane<V>(was_free)) {
    const Three<V> e = d - n;
    const V ee = dot<arithmetic>(e, e);
    const V ne = dot<arithmetic>(n, e);
    const V room = l * l - nn;
    const V square = multiply_add<arithmetic>(ee, room, ne * ne);
    const V root = square_root(select<V>(square > zero, square, zero));
    // From inside, f is the far root of ee f^2 + 2 ne f - room; from outside, the near one.
    const Mask<V> is_plain = bound == Bound::at_most ? ne < zero : ne > zero;
    const V f = bound == Bound::at_most
                    ? quotient(select<V>(is_plain, root - ne, room), select<V>(is_plain, ee, ne + root))
                    : quotient(select<V>(is_plain, zero - ne - root, room), select<V>(is_plain, ee, ne - root));
    const Mask<V> is_within = was_free & (f > zero) & (f < one);
    const V rest = one - f;
    const V floored = select<V>(rest > V(least_rest<T>), rest, V(least_rest<T>));
    rate = select<V>(is_within, quotient(V(terms.per_step), floored), rate);
    n = select(is_within, multiply_add<arithmetic>(f, e, n), n);
    store_axes<V>(terms.n, s, n);
  }
  store_lanes(terms.rate + s, rate);
}

template <class V, Arithmetic arithmetic, Bound bound, Round round>
void place_pairs_by(const PairTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, std::size_t from, std::size_t to) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  for (std::size_t s = from; s < to; s += V::size) {
    const BothEnds<V> ends = gather_ends<V>(terms, x, s);
    const Three<V> d = ends.b - ends.a;
    const V l = load_lanes<V>(terms.l + s);
    const V sum = round == Round::first ? zero : load_lanes<V>(terms.s + s);
    Three<V> n = load_axes<V>(terms.n, s);
    if constexpr (bound != Bound::equal) reach<V, arithmetic, bound>(terms, s, d, l, sum, n);

    const V dd = dot<arithmetic>(d, d);
    const V dn = dot<arithmetic>(d, n);
    const V less = subtract_product<arithmetic>(dd, l, l);
    const V square = subtract_product<arithmetic>(dn * dn, dot<arithmetic>(n, n), less);
    const Mask<V> is_sound = is_sound_square(dd);
    const Mask<V> is_ahead = is_sound & (dn > zero) & (square >= zero);
    const V root = square_root(select<V>(is_ahead, square, one));
    V t = select<V>(is_ahead, quotient(zero - less, dn + root), zero);
    V kept = sum + t;
    if constexpr (bound != Bound::equal) {
      kept = kept_sign(kept, bound == Bound::at_most);
      t = select<V>(is_ahead, kept - sum, zero);  // an infinite sum less itself is not 0
    }
    store_lanes(terms.s + s, kept);

    const Mask<V> is_astray = is_sound & !is_ahead;  // not ^, which is | between AVX-512 masks in xsimd 8.1
    if (any_lane<V>(is_astray)) {
      V radial = quotient(l, square_root(select<V>(is_sound, dd, one))) - one;
      if constexpr (bound != Bound::equal) radial = kept_sign(radial, bound == Bound::at_most);
      t = select<V>(is_astray, radial, t);
      n = select(is_astray, d, n);
    }
    push_ends<V, arithmetic>(terms, x, s, ends, t, n);
  }
}

// Calls with the template arguments that are asked for.
template <class Call>
void by_bound(Bound bound, const Call& call) noexcept {
  if (bound == Bound::equal) return call.template operator()<Bound::equal>();
  if (bound == Bound::at_most) return call.template operator()<Bound::at_most>();
  call.template operator()<Bound::at_least>();
}
template <class Call>
void by_round(Round round, const Call& call) noexcept {
  if (round == Round::first) return call.template operator()<Round::first>();
  call.template operator()<Round::again>();
}

template <class V, Arithmetic arithmetic>
void solve_pair_positions(const PairTerms<Scalar<V>>& terms, Bound bound, Round round, const Axes<Scalar<V>>& x,
                          std::size_t from, std::size_t to) noexcept {
  by_bound(bound,
           [&]<Bound b>() { by_round(round, [&]<Round r>() { place_pairs_by<V, arithmetic, b, r>(terms, x, from, to); }); });
}

template <class V, Arithmetic arithmetic, Round round>
void place_crossing_by(const PairTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, std::size_t from, std::size_t to) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  for (std::size_t s = from; s < to; s += V::size) {
    const BothEnds<V> ends = gather_ends<V>(terms, x, s);
    const Three<V> sum = round == Round::first ? Three<V>{{zero, zero, zero}} : load_axes<V>(terms.n, s);
    const Three<V> free = (ends.b - ends.a) + sum;
    const V square = dot<arithmetic>(free, free);
    const Mask<V> is_sound = is_sound_square(square);
    const V length = square_root(select<V>(is_sound, square, one));
    const V l = load_lanes<V>(terms.l + s);
    const V excess = select<V>(length > l, one - quotient(l, length), zero);
    const Three<V> now = select(is_sound, excess * free, sum);
    store_axes<V>(terms.n, s, now);
    push_ends<V, arithmetic>(terms, x, s, ends, select<V>(is_sound, V(T(-1)), zero), now - sum);
  }
}

template <class V, Arithmetic arithmetic>
void solve_crossing_positions(const PairTerms<Scalar<V>>& terms, Round round, const Axes<Scalar<V>>& x, std::size_t from,
                              std::size_t to) noexcept {
  by_round(round, [&]<Round r>() { place_crossing_by<V, arithmetic, r>(terms, x, from, to); });
}

template <class V, Arithmetic arithmetic>
void solve_line_positions(const LineTerms<Scalar<V>>& terms, Round round, const Axes<Scalar<V>>& x, std::size_t from,
                          std::size_t to) noexcept {
  const V zero(Scalar<V>(0));
  for (std::size_t s = from; s < to; s += V::size) {
    const Three<V> at = gather_axes<V>(x, terms.a + s);
    const Three<V> n1 = load_axes<V>(terms.n1, s);
    const Three<V> n2 = load_axes<V>(terms.n2, s);
    const Three<V> e = at - load_axes<V>(terms.p, s);
    const Mask<V> is_sound = one_norm(e) < V(most_square<Scalar<V>>);
    const V t1 = dot<arithmetic>(n1, e);
    const V t2 = dot<arithmetic>(n2, e);
    const Three<V> on = subtract_product<arithmetic>(subtract_product<arithmetic>(at, t1, n1), t2, n2);
    scatter_axes<V>(x, terms.a + s, select(is_sound, on, at));
    const V s1 = round == Round::first ? zero : load_lanes<V>(terms.s1 + s);
    const V s2 = round == Round::first ? zero : load_lanes<V>(terms.s2 + s);
    store_lanes(terms.s1 + s, select<V>(is_sound, s1 - t1, s1));
    store_lanes(terms.s2 + s, select<V>(is_sound, s2 - t2, s2));
  }
}

// ---- velocity of the position pulses -----------------------------------------------------------------------------------

template <class V, Arithmetic arithmetic>
void update_pair_velocities(const PairTerms<Scalar<V>>& terms, Bound bound, const Axes<Scalar<V>>& x, const Axes<Scalar<V>>& v,
                            std::size_t from, std::size_t to) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  for (std::size_t s = from; s < to; s += V::size) {
    const V sum = load_lanes<V>(terms.s + s);
    const V rate = bound == Bound::equal ? V(terms.per_step) : load_lanes<V>(terms.rate + s);
    push_ends<V, arithmetic>(terms, v, s, gather_ends<V>(terms, v, s), rate * sum, load_axes<V>(terms.n, s));

    const auto [a, b] = gather_ends<V>(terms, x, s);
    const Three<V> d = b - a;
    const V dd = dot<arithmetic>(d, d);
    Mask<V> acts = is_sound_square(dd);
    if (bound != Bound::equal) acts = acts & differ(sum, zero);
    store_axes<V>(terms.n, s, d);
    store_lanes(terms.inverse + s, select<V>(acts, quotient(V(T(1)), select<V>(acts, dd, V(T(1)))), zero));
  }
}

template <class V, Arithmetic arithmetic>
void update_crossing_velocities(const PairTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, const Axes<Scalar<V>>& v,
                                std::size_t from, std::size_t to) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  for (std::size_t s = from; s < to; s += V::size) {
    const Three<V> sum = load_axes<V>(terms.n, s);
    const V pp = dot<arithmetic>(sum, sum);
    const auto [a, b] = gather_ends<V>(terms, x, s);
    const Three<V> d = b - a;
    const V dd = dot<arithmetic>(d, d);
    const V l = load_lanes<V>(terms.l + s);
    const Mask<V> acts = is_sound_square(dd) & ((pp > zero) | (dd > V(least_taut<T>) * (l * l)));
    const V m = select<V>(acts, V(T(2) * terms.per_step) * square_root(pp), zero);
    const V per_length = quotient(one, square_root(select<V>(acts, dd, one)));
    const Three<V> u = select(acts, per_length * d, Three<V>{{zero, zero, zero}});
    store_lanes(terms.m + s, m);
    store_lanes(terms.inverse + s, select<V>(acts, one, zero));
    store_axes<V>(terms.n, s, u);
    push_ends<V, arithmetic>(terms, v, s, gather_ends<V>(terms, v, s), zero - m, u);
  }
}

template <class V, Arithmetic arithmetic>
void update_line_velocities(const LineTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& v, std::size_t from,
                            std::size_t to) noexcept {
  const V rate(terms.per_step);
  for (std::size_t s = from; s < to; s += V::size) {
    const Three<V> at = gather_axes<V>(v, terms.a + s);
    const Three<V> with_1 = multiply_add<arithmetic>(rate * load_lanes<V>(terms.s1 + s), load_axes<V>(terms.n1, s), at);
    scatter_axes<V>(v, terms.a + s,
                    multiply_add<arithmetic>(rate * load_lanes<V>(terms.s2 + s), load_axes<V>(terms.n2, s), with_1));
  }
}

// ---- velocity pulses ---------------------------------------------------------------------------------------------------

template <class V, Arithmetic arithmetic>
void solve_pair_velocities(const PairTerms<Scalar<V>>& terms, Bound bound, Time time, Round round, const Axes<Scalar<V>>& v,
                           std::size_t from, std::size_t to) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const bool is_pull = (bound == Bound::at_most) == (time == Time::forwards);
  for (std::size_t s = from; s < to; s += V::size) {
    const BothEnds<V> ends = gather_ends<V>(terms, v, s);
    const Three<V> d = load_axes<V>(terms.n, s);
    const V du = dot<arithmetic>(d, ends.b - ends.a);
    const V inverse = load_lanes<V>(terms.inverse + s);
    const Mask<V> acts = (magnitude(du) < V(most_square<T>)) & differ(inverse, zero);
    V t = select<V>(acts, zero - du * inverse, zero);
    if (bound != Bound::equal) {
      const V sum = round == Round::first ? zero : load_lanes<V>(terms.m + s);
      const V kept = select<V>(acts, kept_sign(sum + t, is_pull), sum);
      t = select<V>(acts, kept - sum, zero);
      store_lanes(terms.m + s, kept);
    }
    push_ends<V, arithmetic>(terms, v, s, ends, t, d);
  }
}

template <class V, Arithmetic arithmetic>
void solve_crossing_velocities(const PairTerms<Scalar<V>>& terms, Time time, const Axes<Scalar<V>>& v, std::size_t from,
                               std::size_t to) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  for (std::size_t s = from; s < to; s += V::size) {
    const BothEnds<V> ends = gather_ends<V>(terms, v, s);
    const Three<V> u = load_axes<V>(terms.n, s);
    const V rate = dot<arithmetic>(u, ends.b - ends.a);
    const Mask<V> acts = (magnitude(rate) < V(most_square<T>)) & differ(load_lanes<V>(terms.inverse + s), zero);
    const V sum = load_lanes<V>(terms.m + s);
    const V kept = select<V>(acts, kept_sign(sum + rate, time == Time::backwards), sum);
    store_lanes(terms.m + s, kept);
    push_ends<V, arithmetic>(terms, v, s, ends, select<V>(acts, sum - kept, zero), u);
  }
}

template <class V, Arithmetic arithmetic>
void solve_line_velocities(const LineTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& v, std::size_t from,
                           std::size_t to) noexcept {
  for (std::size_t s = from; s < to; s += V::size) {
    const Three<V> at = gather_axes<V>(v, terms.a + s);
    const Three<V> n1 = load_axes<V>(terms.n1, s);
    const Three<V> n2 = load_axes<V>(terms.n2, s);
    const Mask<V> is_sound = one_norm(at) < V(most_square<Scalar<V>>);
    const V t1 = dot<arithmetic>(n1, at);
    const V t2 = dot<arithmetic>(n2, at);
    const Three<V> along = subtract_product<arithmetic>(subtract_product<arithmetic>(at, t1, n1), t2, n2);
    scatter_axes<V>(v, terms.a + s, select(is_sound, along, at));
  }
}

}  // namespace
}  // namespace dvdx
