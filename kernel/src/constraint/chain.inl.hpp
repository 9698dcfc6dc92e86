// Chains of distances, wide: sixteen side by side, each solved as a whole. Chains that share no particle: lone_chain.inl.hpp.
// The scalar twin: chain_reference.hpp; the derivation: constraint.hpp.
#pragma once

#include <cstddef>
#include <cstdint>

#include "constraint/constraint.inl.hpp"

namespace dvdx {
namespace {

template <class V>
Three<V> sound_or_zero(const Three<V>& d, V square) noexcept {
  return select(is_sound_square(square), d, three<V>(V(Scalar<V>(0))));
}

// Eliminates the tridiagonal system downwards, a row at a time.
template <class V, Arithmetic arithmetic>
class Elimination {
  using T = Scalar<V>;

 public:
  explicit Elimination(const ChainTerms<T>& terms) noexcept : terms_(terms), over_(V(T(0))), rest_(V(T(0))) {}

  // below s_{k-1} + own s_k + above s_{k+1} = right; a row that is not sound is s_k = 0.
  void add(std::size_t element, Mask<V> is_sound, V below, V own, V above, V right) noexcept {
    const V zero(T(0));
    const V least = V(least_pivot<T>) * own;
    V pivot = subtract_product<arithmetic>(own, below, over_);
    pivot = select<V>(is_sound & (pivot > least), pivot, select<V>(is_sound, least, V(T(1))));
    over_ = select<V>(is_sound, quotient(above, pivot), zero);
    rest_ = select<V>(is_sound, quotient(subtract_product<arithmetic>(right, below, rest_), pivot), zero);
    store_lanes(terms_.over + element, over_);
    store_lanes(terms_.rest + element, rest_);
  }

 private:
  const ChainTerms<T>& terms_;
  V over_, rest_;
};

// The state of a register's chains before a step of Newton's.
template <class V>
struct Verdict {
  Mask<V> is_off;     // some length is not right yet
  Mask<V> is_astray;  // some link has turned too far or is not sound: pulses along n lead nowhere
  Mask<V> is_far;     // some length is off by more than chain_lost
};

// Eliminates Newton's system at the present positions. grain: the rounding of a position.
template <class V, Arithmetic arithmetic>
Verdict<V> eliminate_lengths(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, std::size_t first, std::size_t links,
                             V grain = V(Scalar<V>(0))) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  Elimination<V, arithmetic> rows(terms);
  Three<V> at = gather_axes<V>(x, terms.a + first);
  Three<V> n_below = three<V>(zero);
  Three<V> n = load_axes<V>(terms.n, first);
  V w = load_lanes<V>(terms.w + first);
  Verdict<V> verdict{zero > zero, zero > zero, zero > zero};
  for (std::size_t k = 0; k < links; ++k) {
    const std::size_t e = first + k * slice;
    const Three<V> next = gather_axes<V>(x, terms.a + e + slice);
    const Three<V> n_above = load_axes<V>(terms.n, e + slice);
    const V w_next = load_lanes<V>(terms.w + e + slice);
    const V l = load_lanes<V>(terms.l + e);
    const Three<V> d = next - at;
    const V dd = dot<arithmetic>(d, d);
    const V dn = dot<arithmetic>(d, n);
    const V nn = dot<arithmetic>(n, n);
    const V less = subtract_product<arithmetic>(dd, l, l);
    const Mask<V> is_ahead = is_sound_square(dd) & (dn > V(least_turn<T>) * nn);
    const Mask<V> is_sound = is_ahead & (nn > zero);
    verdict.is_astray = verdict.is_astray | ((nn > zero) & !is_ahead);
    const V off = magnitude(less);
    verdict.is_off = verdict.is_off | (is_sound & (off > l * multiply_add<arithmetic>(V(chain_tolerance<T>), l, grain)));
    verdict.is_far = verdict.is_far | (is_sound & (off > l * multiply_add<arithmetic>(V(chain_lost<T>), l, grain)));
    rows.add(e, is_sound, zero - w * dot<arithmetic>(d, n_below), (w + w_next) * dn,
             zero - w_next * dot<arithmetic>(d, n_above), V(T(-0.5)) * less);
    at = next;
    n_below = n;
    n = n_above;
    w = w_next;
  }
  return verdict;
}

// Sums over a chain's particles with pulses p: of w |p|^2, and of m |v|^2 after the pulses.
template <class V>
struct Pushed {
  V carried = V(Scalar<V>(0)), moving = V(Scalar<V>(0));

  template <Arithmetic arithmetic>
  void add(const ChainTerms<Scalar<V>>& terms, std::size_t element, V w, const Three<V>& pull, const Three<V>& v) noexcept {
    carried = multiply_add<arithmetic>(w, dot<arithmetic>(pull, pull), carried);
    moving = multiply_add<arithmetic>(load_lanes<V>(terms.m + element), dot<arithmetic>(v, v), moving);
  }
};

enum class Solved : std::uint8_t { positions, positions_summed, velocities };

// Solves upwards and moves particle k by w_k (s_{k-1} n_{k-1} - s_k n_k) where `where` holds; adds s to the sums. frame: the
// velocity that energies are relative to.
template <class V, Arithmetic arithmetic, Solved what>
Pushed<V> substitute(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& columns, std::size_t first, std::size_t links,
                     Mask<V> where, const Three<V>& frame = three<V>(V(Scalar<V>(0)))) noexcept {
  const V zero(Scalar<V>(0));
  Pushed<V> sums;
  V s_above = zero;
  Three<V> pull = three<V>(zero);  // s_k n_k
  for (std::size_t k = links + 1; k-- > 0;) {
    const std::size_t e = first + k * slice;
    V s = zero;
    Three<V> pull_below = three<V>(zero);
    if (k != 0) {
      const std::size_t link = e - slice;
      s = subtract_product<arithmetic>(load_lanes<V>(terms.rest + link), load_lanes<V>(terms.over + link), s_above);
      const V taken = select<V>(where, s, zero);
      if (what == Solved::positions_summed) store_lanes(terms.s + link, load_lanes<V>(terms.s + link) + taken);
      pull_below = s * load_axes<V>(terms.n, link);
    }
    const V w = load_lanes<V>(terms.w + e);
    const Three<V> at = gather_axes<V>(columns, terms.a + e);
    const Three<V> change = pull_below - pull;
    const Three<V> moved = multiply_add<arithmetic>(w, change, at);
    scatter_movable<V>(columns, terms.a + e, select(where, moved, at), terms.w + e);
    if (what == Solved::velocities) sums.template add<arithmetic>(terms, e, w, change, moved - frame);
    s_above = s;
    pull = pull_below;
  }
  return sums;
}

// n = d where `where` holds.
template <class V, Arithmetic arithmetic>
void aim_chain(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, std::size_t first, std::size_t links,
               Mask<V> where) noexcept {
  Three<V> at = gather_axes<V>(x, terms.a + first);
  for (std::size_t k = 0; k < links; ++k) {
    const std::size_t e = first + k * slice;
    const Three<V> next = gather_axes<V>(x, terms.a + e + slice);
    const Three<V> d = next - at;
    store_axes<V>(terms.n, e, select(where, sound_or_zero(d, dot<arithmetic>(d, d)), load_axes<V>(terms.n, e)));
    at = next;
  }
}

template <class V, Arithmetic arithmetic>
void prepare_chains(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, std::size_t from, std::size_t to) noexcept {
  const V zero(Scalar<V>(0));
  for (std::size_t bundle = from; bundle < to; ++bundle) {
    for (std::size_t lane = 0; lane < slice; lane += V::size) {
      aim_chain<V, arithmetic>(terms, x, terms.first[bundle] + lane, terms.links[bundle], zero == zero);
    }
  }
}

// Takes out links that are not sound from the beginning.
template <class V, Arithmetic arithmetic>
void begin_chain(const ChainTerms<Scalar<V>>& terms, Round round, const Axes<Scalar<V>>& x, std::size_t first,
                 std::size_t links) noexcept {
  const V zero(Scalar<V>(0));
  Three<V> at = gather_axes<V>(x, terms.a + first);
  for (std::size_t k = 0; k < links; ++k) {
    const std::size_t e = first + k * slice;
    const Three<V> next = gather_axes<V>(x, terms.a + e + slice);
    const Three<V> d = next - at;
    const Mask<V> is_sound = is_sound_square(dot<arithmetic>(d, d));
    store_axes<V>(terms.n, e, select(is_sound, load_axes<V>(terms.n, e), three<V>(zero)));
    if (round == Round::first) store_lanes(terms.s + e, zero);
    at = next;
  }
}

template <class V>
void keep(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& columns, std::size_t first, std::size_t links,
          const Axes<Scalar<V>>& kept) noexcept {
  for (std::size_t k = 0; k <= links; ++k) {
    const std::size_t e = first + k * slice;
    store_axes<V>(kept, e, gather_axes<V>(columns, terms.a + e));
  }
}

template <class V>
void put_chain_back(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, std::size_t first, std::size_t links,
                    Mask<V> where) noexcept {
  for (std::size_t k = 0; k <= links; ++k) {
    const std::size_t e = first + k * slice;
    const Three<V> now = gather_axes<V>(x, terms.a + e);
    scatter_movable<V>(x, terms.a + e, select(where, load_axes<V>(terms.kept, e), now), terms.w + e);
  }
}

// Each particle follows the one before it to its link's length, from the end that cannot move, or about the centre of mass.
template <class V, Arithmetic arithmetic>
void follow(const ChainTerms<Scalar<V>>& terms, std::size_t first, std::size_t links) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  const V one(T(1));
  const V w_first = load_lanes<V>(terms.w + first);
  V mass = quotient(one, select<V>(w_first > zero, w_first, one));
  Three<V> before = load_axes<V>(terms.kept, first);
  Three<V> moment = three<V>(zero);
  for (std::size_t k = 1; k <= links; ++k) {
    const std::size_t e = first + k * slice;
    const Three<V> at = load_axes<V>(terms.kept, e);
    const Three<V> d = at - before;
    const V dd = dot<arithmetic>(d, d);
    const V w = load_lanes<V>(terms.w + e);
    const Mask<V> is_sound = is_sound_square(dd);
    const Mask<V> moves = is_sound & (w > zero);
    const V t = quotient(load_lanes<V>(terms.l + e - slice), square_root(select<V>(is_sound, dd, one)));
    const Three<V> to = select(moves, multiply_add<arithmetic>(t, d, before), at);
    const V m = select<V>(moves, quotient(one, select<V>(moves, w, one)), zero);
    moment = moment + select(moves, m * (to - at), three<V>(zero));
    mass = mass + m;
    store_axes<V>(terms.kept, e, to);
    before = to;
  }
  const V share = select<V>(w_first > zero, quotient(one, mass), zero);
  for (std::size_t k = 0; k <= links; ++k) {
    const std::size_t e = first + k * slice;
    store_axes<V>(terms.kept, e, subtract_product<arithmetic>(load_axes<V>(terms.kept, e), share, moment));
  }
}

// For chains that have turned too far for pulses along n. Their particles follow each other; velocities get the velocity pulse
// alone. If the last particle cannot move either, Newton's steps along each step's own d correct the lengths if they can.
template <class V, Arithmetic arithmetic>
void follow_and_correct(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, std::size_t first, std::size_t links,
                        Mask<V> where) noexcept {
  const V zero(Scalar<V>(0));
  follow<V, arithmetic>(terms, first, links);
  put_chain_back<V>(terms, x, first, links, where);
  aim_chain<V, arithmetic>(terms, x, first, links, where);
  Mask<V> is_lost = zero > zero;
  for (int step = 0; step < terms.newton; ++step) {
    const Mask<V> is_off = where & eliminate_lengths<V, arithmetic>(terms, x, first, links).is_off & !is_lost;
    if (!any_lane<V>(is_off)) break;
    substitute<V, arithmetic, Solved::positions>(terms, x, first, links, is_off);
    is_lost = is_lost | (where & eliminate_lengths<V, arithmetic>(terms, x, first, links).is_astray);
    aim_chain<V, arithmetic>(terms, x, first, links, where & !is_lost);
  }
  put_chain_back<V>(terms, x, first, links, is_lost);
  for (std::size_t k = 0; k < links; ++k) {
    const std::size_t e = first + k * slice;
    store_lanes(terms.s + e, select<V>(where, zero, load_lanes<V>(terms.s + e)));
  }
}

template <class V, Arithmetic arithmetic>
void place_chain(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, std::size_t first, std::size_t links) noexcept {
  const V zero(Scalar<V>(0));
  Mask<V> is_astray = zero > zero;
  Mask<V> is_off = zero == zero;
  for (int step = 0; step <= terms.newton && any_lane<V>(is_off); ++step) {
    const Verdict<V> verdict = eliminate_lengths<V, arithmetic>(terms, x, first, links);
    is_astray = is_astray | verdict.is_astray;
    is_off = verdict.is_off & !is_astray;
    if (step < terms.newton) substitute<V, arithmetic, Solved::positions_summed>(terms, x, first, links, is_off);
  }
  if (any_lane<V>(is_astray)) follow_and_correct<V, arithmetic>(terms, x, first, links, is_astray);
}

template <class V, Arithmetic arithmetic>
void solve_chain_positions(const ChainTerms<Scalar<V>>& terms, Round round, const Axes<Scalar<V>>& x, std::size_t from,
                           std::size_t to) noexcept {
  for (std::size_t bundle = from; bundle < to; ++bundle) {
    for (std::size_t lane = 0; lane < slice; lane += V::size) {
      const std::size_t first = terms.first[bundle] + lane;
      keep<V>(terms, x, first, terms.links[bundle], terms.kept);
      begin_chain<V, arithmetic>(terms, round, x, first, terms.links[bundle]);
      place_chain<V, arithmetic>(terms, x, first, terms.links[bundle]);
    }
  }
}

// Adds the velocity of the position pulses.
template <class V, Arithmetic arithmetic>
Pushed<V> push_chain(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& v, std::size_t first, std::size_t links,
                     Mask<V> where, V per_step) noexcept {
  const V zero(Scalar<V>(0));
  Pushed<V> sums;
  Three<V> pull_below = three<V>(zero);
  for (std::size_t k = 0; k <= links; ++k) {
    const std::size_t e = first + k * slice;
    Three<V> pull = three<V>(zero);
    if (k < links) pull = (per_step * load_lanes<V>(terms.s + e)) * load_axes<V>(terms.n, e);
    const V w = load_lanes<V>(terms.w + e);
    const Three<V> change = pull_below - pull;
    const Three<V> at = gather_axes<V>(v, terms.a + e);
    const Three<V> moved = multiply_add<arithmetic>(w, change, at);
    scatter_movable<V>(v, terms.a + e, select(where, moved, at), terms.w + e);
    sums.template add<arithmetic>(terms, e, w, change, moved);
    pull_below = pull;
  }
  return sums;
}

template <class V, Arithmetic arithmetic>
void update_chain_velocities(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& x, const Axes<Scalar<V>>& v,
                             std::size_t from, std::size_t to) noexcept {
  const V zero(Scalar<V>(0));
  for (std::size_t bundle = from; bundle < to; ++bundle) {
    for (std::size_t lane = 0; lane < slice; lane += V::size) {
      push_chain<V, arithmetic>(terms, v, terms.first[bundle] + lane, terms.links[bundle], zero == zero, V(terms.per_step));
    }
  }
  prepare_chains<V, arithmetic>(terms, x, from, to);
}

template <class V, Arithmetic arithmetic>
Pushed<V> solve_velocities(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& v, std::size_t first, std::size_t links,
                           Mask<V> where, const Three<V>& frame = three<V>(V(Scalar<V>(0)))) noexcept {
  using T = Scalar<V>;
  const V zero(T(0));
  Elimination<V, arithmetic> rows(terms);
  Three<V> at = gather_axes<V>(v, terms.a + first);
  Three<V> n_below = three<V>(zero);
  Three<V> n = load_axes<V>(terms.n, first);
  V w = load_lanes<V>(terms.w + first);
  for (std::size_t k = 0; k < links; ++k) {
    const std::size_t e = first + k * slice;
    const Three<V> next = gather_axes<V>(v, terms.a + e + slice);
    const Three<V> n_above = load_axes<V>(terms.n, e + slice);
    const V w_next = load_lanes<V>(terms.w + e + slice);
    const V un = dot<arithmetic>(n, next - at);
    const V own = (w + w_next) * dot<arithmetic>(n, n);
    rows.add(e, (magnitude(un) < V(most_square<T>)) & (own > zero), zero - w * dot<arithmetic>(n, n_below), own,
             zero - w_next * dot<arithmetic>(n, n_above), zero - un);
    at = next;
    n_below = n;
    n = n_above;
    w = w_next;
  }
  return substitute<V, arithmetic, Solved::velocities>(terms, v, first, links, where, frame);
}

template <class V, Arithmetic arithmetic>
void solve_chain_velocities(const ChainTerms<Scalar<V>>& terms, const Axes<Scalar<V>>& v, std::size_t from,
                            std::size_t to) noexcept {
  const V zero(Scalar<V>(0));
  for (std::size_t bundle = from; bundle < to; ++bundle) {
    for (std::size_t lane = 0; lane < slice; lane += V::size) {
      solve_velocities<V, arithmetic>(terms, v, terms.first[bundle] + lane, terms.links[bundle], zero == zero);
    }
  }
}

}  // namespace
}  // namespace dvdx
