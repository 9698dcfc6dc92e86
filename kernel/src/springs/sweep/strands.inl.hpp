// Sweeps over a sheet's springs, strand by strand, wide. The scalar twin: sequential_reference.hpp.
#pragma once

#include <cstddef>
#include <cstdint>

#include "springs/sweep/sequential.inl.hpp"

namespace dvdx {
namespace {

// Sweeps the strands of one turn. It has pointers of its own, as those in the terms would be read again after each store.
template <class V, template <class, Damping> class Made, Damping damping, Visit visit, Arithmetic arithmetic>
class TurnSweep {
 public:
  using T = Scalar<V>;

  [[gnu::always_inline]] TurnSweep(const SweepTerms<T>& sweep, const WorkColumns<T>& work, std::uint32_t family) noexcept
      : pitch_(work.x[1] - work.x[0]),
        x_(work.x[0]),
        v_(work.v[0]),
        shift_(work.shift[0]),
        origin_(sweep.origin == CountedFrom::step ? work.origin[0] : nullptr),
        w_(work.w),
        inverse_(sweep.inverse),
        lambda_(sweep.lambda),
        line_force_(sweep.line_force[0]),
        line_force_pitch_(sweep.line_force[1] - sweep.line_force[0]),
        made_(sweep, family),
        h_(sweep.h) {}

  // Takes two registers of springs at a time, of one strand or of two: no two springs of a turn share a particle.
  [[gnu::always_inline]] void run(const Strand* strand, const Strand* end, std::ptrdiff_t step) const noexcept {
    std::size_t k = 0;
    const auto next = [&](Place& place) {
      if (strand == end) return false;
      place = {strand->a + k, strand->b + k, strand->springs + k, strand->count - k};
      k += V::size;
      if (k >= strand->count) {
        strand += step;
        k = 0;
      }
      return true;
    };
    Place first, second;
    while (next(first)) {
      const Ends ends = meet(first);
      if (!next(second)) return move(first, ends, solve_at(first, ends));
      const Ends next_ends = meet(second);
      const Pull<V> pull = solve_at(first, ends);
      const Pull<V> next_pull = solve_at(second, next_ends);
      move(first, ends, pull);
      move(second, next_ends, next_pull);
    }
  }

 private:
  using Ends = Met<V, Three<V>>;

  [[gnu::always_inline]] Ends meet(const Place& at) const noexcept {
    Three<V> apart = load_three<V>(x_ + at.b, pitch_) - load_three<V>(x_ + at.a, pitch_);
    if (origin_ != nullptr) {
      apart = (load_three<V>(origin_ + at.b, pitch_) - load_three<V>(origin_ + at.a, pitch_)) + apart;
    }
    Ends ends;
    ends.shift_a = load_three<V>(shift_ + at.a, pitch_);
    ends.shift_b = load_three<V>(shift_ + at.b, pitch_);
    const Three<V> moved = ends.shift_b - ends.shift_a;
    ends.d = apart + moved;
    ends.r2 = dot<arithmetic>(ends.d, ends.d);
    ends.path = ends.r2;  // not read without damping
    if constexpr (damping == Damping::along) {
      const Three<V> u = load_three<V>(v_ + at.b, pitch_) - load_three<V>(v_ + at.a, pitch_);
      ends.path = dot<arithmetic>(multiply_add<arithmetic>(h_, u, moved), ends.d);
    }
    return ends;
  }

  [[gnu::always_inline]] Pull<V> solve_at(const Place& at, const Ends& ends) const noexcept {
    const V lambda = visit == Visit::first ? V(T(0)) : load_lanes<V>(lambda_ + at.s);
    return solve<damping, arithmetic>(made_.at(at.s, load_lanes<V>(inverse_ + at.s)), ends.r2, ends.path, lambda);
  }

  [[gnu::always_inline]] void move(const Place& at, const Ends& ends, const Pull<V>& pull) const noexcept {
    if constexpr (visit == Visit::redirect) return move_redirected(at, ends, pull);
    const V t_a = load_lanes<V>(w_ + at.a) * pull.t;
    const V t_b = load_lanes<V>(w_ + at.b) * pull.t;
    Three<V> a, b;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      a[axis] = subtract_product_where<arithmetic>(pull.is_sound, ends.shift_a[axis], t_a, ends.d[axis]);
      b[axis] = add_product_where<arithmetic>(pull.is_sound, ends.shift_b[axis], t_b, ends.d[axis]);
    }
    store_shifts(at, a, b);
    if constexpr (visit == Visit::first) {
      if (lambda_ != nullptr) store_lanes(lambda_ + at.s, V(T(0)) + pull.more);
    }
  }

  [[gnu::always_inline]] void move_redirected(const Place& at, const Ends& ends, const Pull<V>& pull) const noexcept {
    const Three<V> line_force = load_three<V>(line_force_ + at.s, line_force_pitch_);
    const V line_force_d = dot<arithmetic>(line_force, ends.d);
    const Mask<V> is_sound = pull.is_sound & (magnitude(line_force_d) < V(most_square<T>));
    const V w_a = load_lanes<V>(w_ + at.a);
    const V w_b = load_lanes<V>(w_ + at.b);
    const V lambda = load_lanes<V>(lambda_ + at.s) + pull.more;
    const Three<V> force = redirected<arithmetic>(line_force, line_force_d, ends.d, w_a + w_b, lambda, pull);
    Three<V> a, b;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      a[axis] = select(is_sound, subtract_product<arithmetic>(ends.shift_a[axis], w_a, force[axis]), ends.shift_a[axis]);
      b[axis] = select(is_sound, multiply_add<arithmetic>(w_b, force[axis], ends.shift_b[axis]), ends.shift_b[axis]);
    }
    store_shifts(at, a, b);
  }

  [[gnu::always_inline]] void store_shifts(const Place& at, const Three<V>& a, const Three<V>& b) const noexcept {
    if (at.count < V::size) {  // lanes beyond the strand may be of the next line, and in flight
      store_three<V>(shift_ + at.a, pitch_, a, at.count);
      store_three<V>(shift_ + at.b, pitch_, b, at.count);
    } else {
      store_three<V>(shift_ + at.a, pitch_, a);
      store_three<V>(shift_ + at.b, pitch_, b);
    }
  }

  std::ptrdiff_t pitch_;
  const T *x_, *v_;
  T* shift_;
  const T* origin_;
  const T *w_, *inverse_;
  T* lambda_;
  const T* line_force_;
  std::ptrdiff_t line_force_pitch_;
  Made<V, damping> made_;
  V h_;
};

template <class V, template <class, Damping> class Made, Damping damping, Visit visit, Arithmetic arithmetic>
void sweep_turn(const SweepTerms<Scalar<V>>& sweep, const WorkColumns<Scalar<V>>& work, const Strand* from, const Strand* to,
                std::ptrdiff_t step) noexcept {
  TurnSweep<V, Made, damping, visit, arithmetic>(sweep, work, from->material).run(from, to, step);
}

template <class V, Arithmetic arithmetic>
void sweep_strands(const SweepTerms<Scalar<V>>& sweep, const WorkColumns<Scalar<V>>& work, Visit visit, std::size_t from,
                   std::size_t to) noexcept {
  if (from == to) return;  // a sheet without springs has no strands to point to
  const auto sweep_by = [&]<Damping damping, Visit v>() {
    const std::ptrdiff_t step = from < to ? 1 : -1;
    const Strand* strand = from < to ? sweep.strands + from : sweep.strands + from - 1;
    const Strand* const end = from < to ? sweep.strands + to : sweep.strands + to - 1;
    while (strand != end) {
      const Strand* next = strand;
      while (next != end && next->turn == strand->turn) next += step;
      if (sweep.materials != nullptr) {
        sweep_turn<V, MadeAlike, damping, v, arithmetic>(sweep, work, strand, next, step);
      } else {
        sweep_turn<V, MadeEach, damping, v, arithmetic>(sweep, work, strand, next, step);
      }
      strand = next;
    }
  };
  if (visit != Visit::redirect) return by_kind(sweep.damping, visit, sweep_by);
  by_kind(sweep.damping, [&]<Damping damping>() { sweep_by.template operator()<damping, Visit::redirect>(); });
}

}  // namespace
}  // namespace dvdx
