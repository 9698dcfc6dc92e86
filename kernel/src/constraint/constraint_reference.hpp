// Constraints, scalar: one after the other. The wide twin: constraint.inl.hpp; the derivation: constraint.hpp.
#pragma once

#include <cmath>

#include "constraint/constraint.hpp"
#include "springs/pull_reference.hpp"

namespace dvdx::reference {

template <class T>
void put(const Axes<T>& columns, std::size_t i, const Vector<T>& value) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) columns[axis][i] = value[axis];
}

template <class T>
Vector<T> between(const PairTerms<T>& terms, const Axes<T>& columns, std::size_t s) noexcept {
  return minus(at(columns, static_cast<std::size_t>(terms.b[s])), at(columns, static_cast<std::size_t>(terms.a[s])));
}

template <Arithmetic arithmetic, class T>
void push_ends(const PairTerms<T>& terms, const Axes<T>& columns, std::size_t s, T t, const Vector<T>& n) noexcept {
  if (t == 0) return;
  const auto a = static_cast<std::size_t>(terms.a[s]);
  const auto b = static_cast<std::size_t>(terms.b[s]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (terms.share_a[s] != 0) {
      columns[axis][a] = subtract_product<arithmetic>(columns[axis][a], terms.share_a[s] * t, n[axis]);
    }
    if (terms.share_b[s] != 0) {
      columns[axis][b] = multiply_add<arithmetic>(terms.share_b[s] * t, n[axis], columns[axis][b]);
    }
  }
}

template <class T>
bool is_sound_square(T square) noexcept {
  return square > least_square<T> && square < most_square<T>;
}

template <class T>
T kept_sign(T sum, bool is_pull) noexcept {
  return (is_pull ? sum < 0 : sum > 0) ? sum : T(0);
}

template <class T>
void prepare_pairs(const PairTerms<T>& terms, const Axes<T>& x, std::size_t from, std::size_t to) noexcept {
  for (std::size_t s = from; s < to; ++s) put(terms.n, s, between(terms, x, s));
}

// ---- position pulses ---------------------------------------------------------------------------------------------------

// The part of the sub-step at which the way from n to n + e reaches the length l, from inside or from outside.
template <Arithmetic arithmetic, class T>
T time_of_violation(const Vector<T>& n, const Vector<T>& e, T nn, T l, Bound bound) noexcept {
  const T ee = inner<arithmetic>(e, e);
  const T ne = inner<arithmetic>(n, e);
  const T room = l * l - nn;
  const T square = multiply_add<arithmetic>(ee, room, ne * ne);
  const T root = std::sqrt(square > 0 ? square : T(0));
  if (bound == Bound::at_most) return ne < 0 ? (root - ne) / ee : room / (ne + root);
  return ne > 0 ? (T(0) - ne - root) / ee : room / (ne - root);
}

template <Arithmetic arithmetic, class T>
void reach(const PairTerms<T>& terms, std::size_t s, const Vector<T>& d, T l, Bound bound) noexcept {
  const Vector<T> n = at(terms.n, s);
  const T dd = inner<arithmetic>(d, d);
  const T nn = inner<arithmetic>(n, n);
  const bool is_violated = bound == Bound::at_most ? dd > l * l : dd < l * l;
  if (!is_violated) return;
  terms.rate[s] = terms.per_step;
  const bool was_free = bound == Bound::at_most ? nn < l * l : nn > l * l;
  if (!was_free) return;
  const Vector<T> e = minus(d, n);
  const T f = time_of_violation<arithmetic>(n, e, nn, l, bound);
  if (!(f > 0 && f < 1)) return;
  const T rest = T(1) - f;
  terms.rate[s] = terms.per_step / (rest > least_rest<T> ? rest : least_rest<T>);
  for (std::size_t axis = 0; axis < 3; ++axis) terms.n[axis][s] = multiply_add<arithmetic>(f, e[axis], n[axis]);
}

template <class T, Arithmetic arithmetic>
void solve_pair_positions(const PairTerms<T>& terms, Bound bound, Round round, const Axes<T>& x, std::size_t from,
                          std::size_t to) noexcept {
  const bool is_pull = bound == Bound::at_most;
  for (std::size_t s = from; s < to; ++s) {
    const Vector<T> d = between(terms, x, s);
    const T l = terms.l[s];
    const T sum = round == Round::first ? T(0) : terms.s[s];
    terms.s[s] = sum;
    if (bound != Bound::equal && sum == 0) reach<arithmetic>(terms, s, d, l, bound);
    const Vector<T> n = at(terms.n, s);

    const T dd = inner<arithmetic>(d, d);
    if (!is_sound_square(dd)) continue;
    const T dn = inner<arithmetic>(d, n);
    const T less = subtract_product<arithmetic>(dd, l, l);
    const T square = subtract_product<arithmetic>(dn * dn, inner<arithmetic>(n, n), less);
    if (dn > 0 && square >= 0) {
      T t = (T(0) - less) / (dn + std::sqrt(square));
      T kept = sum + t;
      if (bound != Bound::equal) {
        kept = kept_sign(kept, is_pull);
        t = kept - sum;
      }
      terms.s[s] = kept;
      push_ends<arithmetic>(terms, x, s, t, n);
    } else {
      const T radial = l / std::sqrt(dd) - T(1);
      push_ends<arithmetic>(terms, x, s, bound == Bound::equal ? radial : kept_sign(radial, is_pull), d);
    }
  }
}

template <class T, Arithmetic arithmetic>
void solve_crossing_positions(const PairTerms<T>& terms, Round round, const Axes<T>& x, std::size_t from,
                              std::size_t to) noexcept {
  for (std::size_t s = from; s < to; ++s) {
    const Vector<T> sum = round == Round::first ? Vector<T>{} : at(terms.n, s);
    put(terms.n, s, sum);
    const Vector<T> free = plus(between(terms, x, s), sum);
    const T square = inner<arithmetic>(free, free);
    if (!is_sound_square(square)) continue;
    const T length = std::sqrt(square);
    const T l = terms.l[s];
    const T excess = length > l ? T(1) - l / length : T(0);
    const Vector<T> now = times(excess, free);
    const Vector<T> more = minus(now, sum);
    put(terms.n, s, now);
    push_ends<arithmetic>(terms, x, s, T(-1), more);
  }
}

template <class T, Arithmetic arithmetic>
void solve_line_positions(const LineTerms<T>& terms, Round round, const Axes<T>& x, std::size_t from, std::size_t to) noexcept {
  for (std::size_t s = from; s < to; ++s) {
    const auto a = static_cast<std::size_t>(terms.a[s]);
    if (round == Round::first) terms.s1[s] = terms.s2[s] = T(0);
    const Vector<T> e = minus(at(x, a), at(terms.p, s));
    if (!((std::abs(e[0]) + std::abs(e[1])) + std::abs(e[2]) < most_square<T>)) continue;
    const T t1 = inner<arithmetic>(at(terms.n1, s), e);
    const T t2 = inner<arithmetic>(at(terms.n2, s), e);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const T without_1 = subtract_product<arithmetic>(x[axis][a], t1, terms.n1[axis][s]);
      x[axis][a] = subtract_product<arithmetic>(without_1, t2, terms.n2[axis][s]);
    }
    terms.s1[s] = terms.s1[s] - t1;
    terms.s2[s] = terms.s2[s] - t2;
  }
}

// ---- velocity of the position pulses -----------------------------------------------------------------------------------

template <class T, Arithmetic arithmetic>
void update_pair_velocities(const PairTerms<T>& terms, Bound bound, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                            std::size_t to) noexcept {
  for (std::size_t s = from; s < to; ++s) {
    const T rate = bound == Bound::equal ? terms.per_step : terms.rate[s];
    push_ends<arithmetic>(terms, v, s, rate * terms.s[s], at(terms.n, s));
    const Vector<T> d = between(terms, x, s);
    const T dd = inner<arithmetic>(d, d);
    const bool acts = is_sound_square(dd) && (bound == Bound::equal || terms.s[s] != 0);
    terms.inverse[s] = acts ? T(1) / dd : T(0);
    put(terms.n, s, d);
  }
}

template <class T, Arithmetic arithmetic>
void update_crossing_velocities(const PairTerms<T>& terms, const Axes<T>& x, const Axes<T>& v, std::size_t from,
                                std::size_t to) noexcept {
  for (std::size_t s = from; s < to; ++s) {
    const Vector<T> sum = at(terms.n, s);
    const T pp = inner<arithmetic>(sum, sum);
    const Vector<T> d = between(terms, x, s);
    const T dd = inner<arithmetic>(d, d);
    const T l = terms.l[s];
    const bool acts = is_sound_square(dd) && (pp > 0 || dd > least_taut<T> * (l * l));
    const T m = acts ? (T(2) * terms.per_step) * std::sqrt(pp) : T(0);
    const Vector<T> u = acts ? times(T(1) / std::sqrt(dd), d) : Vector<T>{};
    terms.m[s] = m;
    terms.inverse[s] = acts ? T(1) : T(0);
    put(terms.n, s, u);
    push_ends<arithmetic>(terms, v, s, T(0) - m, u);
  }
}

template <class T, Arithmetic arithmetic>
void update_line_velocities(const LineTerms<T>& terms, const Axes<T>& v, std::size_t from, std::size_t to) noexcept {
  for (std::size_t s = from; s < to; ++s) {
    const auto a = static_cast<std::size_t>(terms.a[s]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const T with_1 = multiply_add<arithmetic>(terms.per_step * terms.s1[s], terms.n1[axis][s], v[axis][a]);
      v[axis][a] = multiply_add<arithmetic>(terms.per_step * terms.s2[s], terms.n2[axis][s], with_1);
    }
  }
}

// ---- velocity pulses ---------------------------------------------------------------------------------------------------

template <class T, Arithmetic arithmetic>
void solve_pair_velocities(const PairTerms<T>& terms, Bound bound, Time time, Round round, const Axes<T>& v, std::size_t from,
                           std::size_t to) noexcept {
  const bool is_pull = (bound == Bound::at_most) == (time == Time::forwards);
  for (std::size_t s = from; s < to; ++s) {
    const T sum = bound == Bound::equal || round == Round::first ? T(0) : terms.m[s];
    if (bound != Bound::equal) terms.m[s] = sum;
    const Vector<T> d = at(terms.n, s);
    const T du = inner<arithmetic>(d, between(terms, v, s));
    if (terms.inverse[s] == 0 || !(std::abs(du) < most_square<T>)) continue;
    T t = T(0) - du * terms.inverse[s];
    if (bound != Bound::equal) {
      const T kept = kept_sign(sum + t, is_pull);
      t = kept - sum;
      terms.m[s] = kept;
    }
    push_ends<arithmetic>(terms, v, s, t, d);
  }
}

template <class T, Arithmetic arithmetic>
void solve_crossing_velocities(const PairTerms<T>& terms, Time time, const Axes<T>& v, std::size_t from,
                               std::size_t to) noexcept {
  for (std::size_t s = from; s < to; ++s) {
    const Vector<T> u = at(terms.n, s);
    const T rate = inner<arithmetic>(u, between(terms, v, s));
    if (terms.inverse[s] == 0 || !(std::abs(rate) < most_square<T>)) continue;
    const T sum = terms.m[s];
    const T kept = kept_sign(sum + rate, time == Time::backwards);
    terms.m[s] = kept;
    push_ends<arithmetic>(terms, v, s, sum - kept, u);
  }
}

template <class T, Arithmetic arithmetic>
void solve_line_velocities(const LineTerms<T>& terms, const Axes<T>& v, std::size_t from, std::size_t to) noexcept {
  for (std::size_t s = from; s < to; ++s) {
    const auto a = static_cast<std::size_t>(terms.a[s]);
    const Vector<T> at_a = at(v, a);
    if (!((std::abs(at_a[0]) + std::abs(at_a[1])) + std::abs(at_a[2]) < most_square<T>)) continue;
    const T t1 = inner<arithmetic>(at(terms.n1, s), at_a);
    const T t2 = inner<arithmetic>(at(terms.n2, s), at_a);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const T without_1 = subtract_product<arithmetic>(at_a[axis], t1, terms.n1[axis][s]);
      v[axis][a] = subtract_product<arithmetic>(without_1, t2, terms.n2[axis][s]);
    }
  }
}

}  // namespace dvdx::reference
