// Particles and balls, wide: one in each lane. The scalar twin: ball_reference.hpp; the derivation: ball.hpp.
#pragma once

#include "constraint/constraint.inl.hpp"
#include "simd/lanes.hpp"
#include "skin/ball.hpp"

namespace dvdx {
namespace {

// Gathers elements that mostly stand side by side, as those of a sheet's rows do.
template <class V>
[[gnu::always_inline]] inline Three<V> near_axes(const Axes<Scalar<V>>& columns, const std::int32_t* element) noexcept {
  std::int32_t apart = 0;
  for (std::size_t k = 1; k < V::size; ++k) apart |= (element[k] - element[0]) ^ static_cast<std::int32_t>(k);
  return apart == 0 ? load_axes<V>(columns, static_cast<std::size_t>(element[0])) : gather_axes<V>(columns, element);
}

template <class V>
void prepare_balls(const BallTerms<Scalar<V>>& terms, const WorkColumns<Scalar<V>>& work, std::size_t from,
                   std::size_t to) noexcept {
  for (std::size_t s = from; s < to; s += V::size) {
    store_axes<V>(terms.n, s, near_axes<V>(work.x, terms.element + s) - load_axes<V>(terms.c, s));
  }
}

// Returns true if BallBounds::is_broken() may hold in some lane. Uses the same products, without a root or a quotient. A
// particle enters a ball with f < 1 only if -room < root - nd <= 2 |nd|; an eighth more than that is more than rounding.
template <class V, Bound bound, Arithmetic arithmetic>
[[gnu::always_inline]] inline bool may_be_broken(const BallTerms<Scalar<V>>& terms, std::size_t s, const Three<V>& e) noexcept {
  const V r = load_lanes<V>(terms.r + s);
  const V rr = r * r;
  const V ee = dot<arithmetic>(e, e);
  if constexpr (bound == Bound::at_most) return any_lane<V>(ee > rr);
  const Three<V> n = load_axes<V>(terms.n, s);
  const V room = rr - dot<arithmetic>(n, n);
  const V nd = dot<arithmetic>(n, e - n);
  return any_lane<V>((ee < rr) | !(room < V(Scalar<V>(0))) | (room > V(Scalar<V>(2.25)) * nd));
}

// The bounds of a register of particles, in their balls' frames.
template <class V, Bound bound, Arithmetic arithmetic>
class BallBounds {
  using T = Scalar<V>;

 public:
  BallBounds(const Three<V>& n, const Three<V>& e, V r, T per_step) noexcept
      : n_(n), e_(e), d_(e - n), r_(r), rr_(r * r), per_step_(per_step) {
    const V zero(T(0));
    const V one(T(1));
    ee_ = dot<arithmetic>(e, e);
    nn_ = dot<arithmetic>(n, n);
    const V nd = dot<arithmetic>(n, d_);
    const V dd = dot<arithmetic>(d_, d_);
    const V room = rr_ - nn_;
    const V square = multiply_add<arithmetic>(dd, room, nd * nd);
    const V root = square_root(select<V>(square > zero, square, zero));
    const V near = V(on_ball<T>) * rr_;
    if constexpr (bound == Bound::at_most) {
      const Mask<V> is_back = nd < zero;
      f_ = quotient(select<V>(is_back, root - nd, room), select<V>(is_back, dd, nd + root));
      is_hit_ = (room > near) & (f_ > zero) & (f_ < one);
      is_broken_ = ee_ > rr_;
      was_broken_ = room < zero;
    } else {
      f_ = quotient(room, nd - root);
      const Mask<V> goes_in = (room < zero) & (nd < zero) & (square > zero) & (f_ < one);
      is_hit_ = (room < zero - near) & goes_in;
      is_broken_ = (ee_ < rr_) | goes_in | !(room < zero);
      was_broken_ = room > zero;
    }
  }

  [[nodiscard]] Mask<V> is_broken() const noexcept { return is_broken_; }
  [[nodiscard]] Mask<V> is_sound() const noexcept { return (ee_ < V(most_square<T>)) & (nn_ < V(most_square<T>)); }

  void keep(Three<V>& e, Three<V>& u) const noexcept {
    const V zero(T(0));
    const V one(T(1));
    const Mask<V> has_start = is_hit_ | (nn_ > V(least_square<T>));
    Three<V> p, way;
    V rate;
    reach(p, way, rate);

    const V ee = dot<arithmetic>(way, way);
    const V pp = dot<arithmetic>(p, p);
    const V pe = dot<arithmetic>(p, way);
    const Mask<V> is_inside = ee < rr_;
    const Mask<V> is_out = bound == Bound::at_most ? ee > rr_ : (is_inside | (pe < pp));
    const V less = subtract_product<arithmetic>(ee, r_, r_);
    const V square = subtract_product<arithmetic>(pe * pe, pp, less);
    Mask<V> is_ahead = is_out & (pe > zero) & (square >= zero);
    if constexpr (bound == Bound::at_least) is_ahead = is_ahead & is_inside;
    const V root = square_root(select<V>(is_ahead, square, one));
    const V s = select<V>(is_ahead, quotient(zero - less, pe + root), zero);
    const V push = rate * s;
    const Three<V> e_pushed = multiply_add<arithmetic>(s, p, way);
    const Three<V> u_pushed = brake(e_pushed, zero - push, multiply_add<arithmetic>(push, p, u));

    const Mask<V> is_astray = is_out & !is_ahead;  // not ^, which is | between AVX-512 masks in xsimd 8.1
    Three<V> e_astray, u_astray;
    if constexpr (bound == Bound::at_most) {
      set_onto(way, u, e_astray, u_astray);
    } else {
      e_astray = subtract_product<arithmetic>(way, quotient(pe - pp, pp), p);
      u_astray = brake(p, zero, u);
    }
    Three<V> e_kept = select(is_ahead, e_pushed, select(is_astray, e_astray, select(was_broken_, way, e)));
    Three<V> u_kept = select(is_ahead, u_pushed, select(is_astray, u_astray, u));
    if (!all_lanes<V>(has_start)) {
      Three<V> e_set, u_set;
      set_onto(e, u, e_set, u_set);
      e_kept = select(has_start, e_kept, e_set);
      u_kept = select(has_start, u_kept, u_set);
    }
    e = e_kept;
    u = u_kept;
    if constexpr (bound == Bound::at_most) {
      const Mask<V> is_ball = rr_ > V(least_square<T>);
      e = select(is_ball, e, three<V>(zero));
      u = select(is_ball, u, three<V>(zero));
    }
  }

 private:
  void reach(Three<V>& p, Three<V>& way, V& rate) const noexcept {
    const V one(T(1));
    const V left = one - f_;
    const V floored = select<V>(left > V(least_part_left<T>), left, V(least_part_left<T>));
    rate = select<V>(is_hit_, quotient(V(per_step_), floored), V(per_step_));
    const V k = quotient(r_, square_root(select<V>(is_hit_, one, nn_)));
    const Three<V> on = k * n_;
    p = select(is_hit_, multiply_add<arithmetic>(f_, d_, n_), on);
    way = select(is_hit_, e_, e_ + (on - n_));
  }

  void set_onto(const Three<V>& e, const Three<V>& u, Three<V>& e_set, Three<V>& u_set) const noexcept {
    const V ee = dot<arithmetic>(e, e);
    const Mask<V> is_apart = ee > V(least_square<T>);
    const Three<V> on = quotient(r_, square_root(select<V>(is_apart, ee, V(T(1))))) * e;
    e_set = select(is_apart, on, e);
    u_set = select(is_apart, brake(on, V(T(0)), u), u);
  }

  [[nodiscard]] Three<V> brake(const Three<V>& q, V most, const Three<V>& u) const noexcept {
    const V t = quotient(V(T(0)) - dot<arithmetic>(u, q), dot<arithmetic>(q, q));
    const bool is_pull = (bound == Bound::at_most) == (per_step_ > 0);
    const V m = select<V>(is_pull ? t < most : t > most, t, most);
    return multiply_add<arithmetic>(m, q, u);
  }

  Three<V> n_, e_, d_;
  V r_, rr_;
  T per_step_;
  V ee_, nn_, f_;
  Mask<V> is_hit_, is_broken_, was_broken_;
};

template <class V>
void scatter_where(const std::array<Scalar<V>*, 3>& columns, const std::int32_t* index, const Three<V>& value,
                   const Mask<V>& where) noexcept {
  using T = Scalar<V>;
  alignas(64) T lanes[4][V::size];
  for (std::size_t axis = 0; axis < 3; ++axis) store_lanes(lanes[axis], value[axis]);
  store_lanes(lanes[3], select<V>(where, V(T(1)), V(T(0))));
  for (std::size_t k = 0; k < V::size; ++k) {
    if (lanes[3][k] == 0) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) columns[axis][index[k]] = lanes[axis][k];
  }
}

template <class V, Bound bound, Arithmetic arithmetic>
void keep_in_balls_by(const BallTerms<Scalar<V>>& terms, const WorkColumns<Scalar<V>>& work, std::size_t from,
                      std::size_t to) noexcept {
  using T = Scalar<V>;
  for (std::size_t s = from; s < to; s += V::size) {
    const std::int32_t* const element = terms.element + s;
    const Three<V> c = load_axes<V>(terms.c, s);
    Three<V> e = near_axes<V>(work.x, element) - c;
    if (!may_be_broken<V, bound, arithmetic>(terms, s, e)) {
      store_axes<V>(terms.n, s, e);
      continue;
    }
    const BallBounds<V, bound, arithmetic> of(load_axes<V>(terms.n, s), e, load_lanes<V>(terms.r + s), terms.per_step);
    Mask<V> acts = of.is_broken() & of.is_sound();
    if (any_lane<V>(acts)) {
      const Three<V> moves = load_axes<V>(terms.u, s);
      Three<V> u = gather_axes<V>(work.v, element) - moves;
      alignas(64) T w[V::size];
      for (std::size_t k = 0; k < V::size; ++k) w[k] = work.w[element[k]];
      acts = acts & (one_norm(u) < V(most_square<T>)) & differ(load_lanes<V>(w), V(T(0)));
      Three<V> kept = e;
      of.keep(kept, u);
      const Three<V> x = c + kept;
      scatter_where<V>(work.x, element, x, acts);
      scatter_where<V>(work.v, element, moves + u, acts);
      e = select(acts, x - c, e);
    }
    store_axes<V>(terms.n, s, e);
  }
}

template <class V, Arithmetic arithmetic>
void keep_in_balls(const BallTerms<Scalar<V>>& terms, Bound bound, const WorkColumns<Scalar<V>>& work, std::size_t from,
                   std::size_t to) noexcept {
  if (bound == Bound::at_most) return keep_in_balls_by<V, Bound::at_most, arithmetic>(terms, work, from, to);
  keep_in_balls_by<V, Bound::at_least, arithmetic>(terms, work, from, to);
}

}  // namespace
}  // namespace dvdx
