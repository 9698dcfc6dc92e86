// Particles and balls, scalar: one after the other. The wide twin: ball.inl.hpp; the derivation: ball.hpp.
#pragma once

#include <cmath>

#include "skin/ball.hpp"
#include "springs/pull_reference.hpp"

namespace dvdx::reference {

template <class T>
void prepare_balls(const BallTerms<T>& terms, const WorkColumns<T>& work, std::size_t from, std::size_t to) noexcept {
  for (std::size_t s = from; s < to; ++s) {
    const Vector<T> n = minus(at(work.x, static_cast<std::size_t>(terms.element[s])), at(terms.c, s));
    for (std::size_t axis = 0; axis < 3; ++axis) terms.n[axis][s] = n[axis];
  }
}

// In the ball's frame: where the bound was reached, where the particle then goes, and 1/tau.
template <class T>
struct Reached {
  Vector<T> p, e;
  T rate;
};

template <Bound bound, Arithmetic arithmetic, class T>
class BallBound {
 public:
  BallBound(const Vector<T>& n, const Vector<T>& e, T r, T per_step) noexcept
      : n_(n), e_(e), d_(minus(e, n)), r_(r), rr_(r * r), per_step_(per_step) {
    ee_ = inner<arithmetic>(e, e);
    nn_ = inner<arithmetic>(n, n);
    const T nd = inner<arithmetic>(n, d_);
    const T dd = inner<arithmetic>(d_, d_);
    const T room = rr_ - nn_;
    const T square = multiply_add<arithmetic>(dd, room, nd * nd);
    const T root = std::sqrt(square > 0 ? square : T(0));
    const T near = on_ball<T> * rr_;
    if constexpr (bound == Bound::at_most) {
      f_ = nd < 0 ? (root - nd) / dd : room / (nd + root);
      is_hit_ = room > near && f_ > 0 && f_ < 1;
      is_broken_ = ee_ > rr_;
    } else {
      f_ = room / (nd - root);
      const bool goes_in = room < 0 && nd < 0 && square > 0 && f_ < 1;
      is_hit_ = room < T(0) - near && goes_in;
      is_broken_ = ee_ < rr_ || goes_in || !(room < 0);
    }
    was_broken_ = bound == Bound::at_most ? room < 0 : room > 0;
  }

  [[nodiscard]] bool is_broken() const noexcept { return is_broken_; }
  [[nodiscard]] bool is_sound() const noexcept { return ee_ < most_square<T> && nn_ < most_square<T>; }

  // Applies both pulses, in the ball's frame.
  void keep(Vector<T>& e, Vector<T>& u) const noexcept {
    if (bound == Bound::at_most && !(rr_ > least_square<T>)) {
      e = u = {};
      return;
    }
    if (!is_hit_ && !(nn_ > least_square<T>)) return set_onto(e, u);
    const auto [p, way, rate] = reached();
    const T ee = inner<arithmetic>(way, way);
    const T pp = inner<arithmetic>(p, p);
    const T pe = inner<arithmetic>(p, way);
    const bool is_inside = ee < rr_;
    if (bound == Bound::at_most ? !(ee > rr_) : !(is_inside || pe < pp)) {
      if (was_broken_) e = way;
      return;
    }
    const T less = subtract_product<arithmetic>(ee, r_, r_);
    const T square = subtract_product<arithmetic>(pe * pe, pp, less);
    if (pe > 0 && square >= 0 && (bound == Bound::at_most || is_inside)) {
      const T s = (T(0) - less) / (pe + std::sqrt(square));
      const T push = rate * s;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        e[axis] = multiply_add<arithmetic>(s, p[axis], way[axis]);
        u[axis] = multiply_add<arithmetic>(push, p[axis], u[axis]);
      }
      return brake(e, T(0) - push, u);
    }
    if constexpr (bound == Bound::at_most) {
      e = way;
      return set_onto(e, u);
    }
    const T t = (pe - pp) / pp;
    for (std::size_t axis = 0; axis < 3; ++axis) e[axis] = subtract_product<arithmetic>(way[axis], t, p[axis]);
    brake(p, T(0), u);
  }

 private:
  [[nodiscard]] Reached<T> reached() const noexcept {
    Reached<T> found{{}, e_, per_step_};
    if (is_hit_) {
      const T left = T(1) - f_;
      found.rate = per_step_ / (left > least_part_left<T> ? left : least_part_left<T>);
      for (std::size_t axis = 0; axis < 3; ++axis) found.p[axis] = multiply_add<arithmetic>(f_, d_[axis], n_[axis]);
    } else {
      found.p = times(r_ / std::sqrt(nn_), n_);
      found.e = plus(e_, minus(found.p, n_));
    }
    return found;
  }

  void set_onto(Vector<T>& e, Vector<T>& u) const noexcept {
    const T ee = inner<arithmetic>(e, e);
    if (!(ee > least_square<T>)) return;
    e = times(r_ / std::sqrt(ee), e);
    brake(e, T(0), u);
  }

  // The velocity pulse along q. -m is at most what the position pulse gave.
  void brake(const Vector<T>& q, T most, Vector<T>& u) const noexcept {
    const T t = (T(0) - inner<arithmetic>(u, q)) / inner<arithmetic>(q, q);
    const bool is_pull = (bound == Bound::at_most) == (per_step_ > 0);
    const T m = (is_pull ? t < most : t > most) ? t : most;
    for (std::size_t axis = 0; axis < 3; ++axis) u[axis] = multiply_add<arithmetic>(m, q[axis], u[axis]);
  }

  Vector<T> n_, e_, d_;
  T r_, rr_, per_step_;
  T ee_{}, nn_{}, f_{};
  bool is_hit_ = false, is_broken_ = false, was_broken_ = false;  // reached on the way; at its end or on it; at its start
};

template <Bound bound, class T, Arithmetic arithmetic>
void keep_in_balls_by(const BallTerms<T>& terms, const WorkColumns<T>& work, std::size_t from, std::size_t to) noexcept {
  for (std::size_t s = from; s < to; ++s) {
    const auto i = static_cast<std::size_t>(terms.element[s]);
    const Vector<T> c = at(terms.c, s);
    Vector<T> n = minus(at(work.x, i), c);
    Vector<T> u = minus(at(work.v, i), at(terms.u, s));
    const BallBound<bound, arithmetic, T> of(at(terms.n, s), n, terms.r[s], terms.per_step);
    const bool is_slow = (std::abs(u[0]) + std::abs(u[1])) + std::abs(u[2]) < most_square<T>;
    if (of.is_broken() && of.is_sound() && is_slow && work.w[i] != 0) {
      of.keep(n, u);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        work.x[axis][i] = c[axis] + n[axis];
        work.v[axis][i] = terms.u[axis][s] + u[axis];
        n[axis] = work.x[axis][i] - c[axis];
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) terms.n[axis][s] = n[axis];
  }
}

template <class T, Arithmetic arithmetic>
void keep_in_balls(const BallTerms<T>& terms, Bound bound, const WorkColumns<T>& work, std::size_t from,
                   std::size_t to) noexcept {
  if (bound == Bound::at_most) return keep_in_balls_by<Bound::at_most, T, arithmetic>(terms, work, from, to);
  keep_in_balls_by<Bound::at_least, T, arithmetic>(terms, work, from, to);
}

}  // namespace dvdx::reference
