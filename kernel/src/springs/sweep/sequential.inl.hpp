// Gauss-Seidel sweeps over springs, wide. The scalar twin: sequential_reference.hpp; the method: springs/sweep/sweep_scheme.cpp.
#pragma once

#include "springs/pull.inl.hpp"

namespace dvdx {
namespace {

template <class V>
struct Spring {
  V kappa, eta, l, inverse;
};

// Read from a spring's two ends, Three or Records of V: their shifts, and d with them. path: how far they move along d.
template <class V, class Axes>
struct Met {
  Axes shift_a, shift_b, d;
  V r2, path;
};

// more: of lambda. Each end's shift moves by -+ w t d. y: inverse length.
template <class V>
struct Pull {
  Mask<V> is_sound;
  V more, t, y;
};

// A visit has three parts: meet the ends, solve, move the ends. One spring's chain of roundings takes longer than its
// arithmetic: a core is kept busy by the parts of several that stand side by side.
template <Damping damping, Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline Pull<V> solve(const Spring<V>& spring, V r2, V path, V lambda) noexcept {
  using T = Scalar<V>;
  Mask<V> is_sound = (r2 > V(least_square<T>)) & (r2 < V(most_square<T>));
  const V y = inverse_root<arithmetic>(r2);
  V g = spring.kappa * subtract_product<arithmetic>(spring.l, r2, y);  // -kappa C
  if constexpr (damping == Damping::along) {
    is_sound = is_sound & (magnitude(path) < V(most_square<T>));
    g = subtract_product<arithmetic>(g, spring.eta * y, path);
  }
  const V more = product_where<V>(is_sound, g - lambda, spring.inverse);
  return {is_sound, more, more * y, y};
}

// By what a spring at d moves its ends, if the force that its line gave it leads along the spring then. w: of both ends.
template <Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline Three<V> redirected(const Three<V>& line_force, V line_force_d, const Three<V>& d, V w, V lambda,
                                                  const Pull<V>& pull) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const V turned = (zero - lambda) * pull.y * w;
  const V eased =
      select<V>(turned > V(Scalar<V>(least_redirected)), quotient(one, one + select<V>(turned > zero, turned, zero)), zero);
  const V along = pull.y * line_force_d;
  const V s = multiply_add<arithmetic>(eased, along * pull.y, pull.t);
  Three<V> force;
  for (std::size_t axis = 0; axis < 3; ++axis) force[axis] = subtract_product<arithmetic>(s * d[axis], eased, line_force[axis]);
  return force;
}

// ---- strands -----------------------------------------------------------------------------------------------------------

template <class V>
[[gnu::always_inline]] inline Three<V> load_three(const Scalar<V>* p, std::ptrdiff_t pitch) noexcept {
  return {{load_lanes<V>(p), load_lanes<V>(p + pitch), load_lanes<V>(p + 2 * pitch)}};
}
template <class V>
[[gnu::always_inline]] inline void store_three(Scalar<V>* p, std::ptrdiff_t pitch, const Three<V>& value) noexcept {
  for (std::ptrdiff_t axis = 0; axis < 3; ++axis) store_lanes(p + axis * pitch, value.at[axis]);
}
// Their first n lanes.
template <class V>
[[gnu::always_inline]] inline void store_three(Scalar<V>* p, std::ptrdiff_t pitch, const Three<V>& value,
                                               std::size_t n) noexcept {
  for (std::ptrdiff_t axis = 0; axis < 3; ++axis) store_first_lanes(p + axis * pitch, n, value.at[axis]);
}

// Where a register of springs stands: its ends, its columns, and how many of its lanes are springs.
struct Place {
  std::size_t a, b, s, count;
};

// The coefficients of the springs of a turn, all alike or each by itself.
template <class V, Damping damping>
class MadeAlike {
 public:
  [[gnu::always_inline]] MadeAlike(const SweepTerms<Scalar<V>>& sweep, std::uint32_t family) noexcept
      : kappa_(sweep.families[family].kappa), eta_(sweep.families[family].eta), l_(sweep.families[family].l) {}
  [[gnu::always_inline]] Spring<V> at(std::size_t /*s*/, V inverse) const noexcept { return {kappa_, eta_, l_, inverse}; }

 private:
  V kappa_, eta_, l_;
};
template <class V, Damping damping>
class MadeEach {
 public:
  [[gnu::always_inline]] MadeEach(const SweepTerms<Scalar<V>>& sweep, std::uint32_t /*family*/) noexcept
      : kappa_(sweep.kappa), eta_(sweep.eta), l_(sweep.l) {}
  [[gnu::always_inline]] Spring<V> at(std::size_t s, V inverse) const noexcept {
    const V kappa = load_lanes<V>(kappa_ + s);
    V eta = kappa;  // not read where nothing damps
    if constexpr (damping == Damping::along) eta = load_lanes<V>(eta_ + s);
    return {kappa, eta, load_lanes<V>(l_ + s), inverse};
  }

 private:
  const Scalar<V>*kappa_, *eta_, *l_;
};

// The strands of one turn. It has pointers of its own: those in the terms would be read again after each store.
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

  // Two registers of springs at a time, of one strand or of two: none of a turn's springs shares a particle with another.
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
    ends.path = ends.r2;  // not read where nothing damps
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
    if (at.count < V::size) {  // what lies beyond the strand may be the next line's, and in flight
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
  TurnSweep<V, Made, damping, visit, arithmetic>(sweep, work, from->family).run(from, to, step);
}

// ---- ranges ------------------------------------------------------------------------------------------------------------

template <class V>
struct Coefficients {
  V kappa, eta, inverse, w_a, w_b;
};

template <class V>
[[gnu::always_inline]] inline Coefficients<V> coefficients_of(const RangeTerms<Scalar<V>>& terms, std::size_t s) noexcept {
  const Scalar<V>* const set = terms.coefficients + terms.coefficients_of[s / slice] + s % slice;
  const auto nth = [&](std::size_t n) { return load_lanes<V>(set + n * slice); };
  return {nth(0), nth(1), nth(2), nth(3), nth(4)};
}

// c + a b and c - a b, as the _where of lanes.hpp do: fast arithmetic alone rounds once.
template <Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline V add_at_once(V c, V a, V b) noexcept {
  if constexpr (arithmetic != Arithmetic::fast) return c + a * b;
  return fused_multiply_add(a, b, c);
}
template <Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline V subtract_at_once(V c, V a, V b) noexcept {
  if constexpr (arithmetic != Arithmetic::fast) return c - a * b;
  return fused_negative_multiply_add(a, b, c);
}

// Records are turned into lanes only where a spring's numbers meet: d for its length, and t on the way back.
template <class V, Damping damping, Visit visit, Arithmetic arithmetic>
class RangeSweep {
 public:
  using T = Scalar<V>;

  explicit RangeSweep(const SweepTerms<T>& sweep) noexcept : sweep_(sweep), terms_(sweep.ranges) {}

  // The next springs' ends are met while these are solved, which none of them shares: 8 to 10 % on AVX-512 in float32, 0 to 3 %
  // where roots are estimates. Elsewhere registers are too few: it lost 2 to 5 %.
  static constexpr bool meets_ahead = sizeof(V) == 64 && sizeof(T) == 4;

  // Springs that stand alike follow each other.
  [[gnu::always_inline]] void run(std::size_t from, std::size_t to) const noexcept {
    if constexpr (!holds_every_fourth<V>) {
      run_alike<Stand::anywhere>(from, to);
    } else {
      for (std::size_t end = from; from < to; from = end) {
        const Stand stand = terms_.stand[from / slice];
        while (end < to && terms_.stand[end / slice] == stand) end += slice;
        if (stand == Stand::side_by_side) {
          run_alike<Stand::side_by_side>(from, end);
        } else if (stand == Stand::in_turn) {
          run_alike<Stand::in_turn>(from, end);
        } else {
          run_alike<Stand::anywhere>(from, end);
        }
      }
    }
  }

  template <Stand stand>
  [[gnu::always_inline]] void run_alike(std::size_t from, std::size_t to) const noexcept {
    if (from == to) return;
    std::size_t s = from;
    if constexpr (meets_ahead) {
      Ends ends = meet<stand>(s);
      for (; s + V::size < to; s += V::size) {
        const Moves moves = solve_at(s, ends);
        const Ends next = meet<stand>(s + V::size);
        move<stand>(s, ends, moves);
        hand_on(next, ends);
      }
      move<stand>(s, ends, solve_at(s, ends));
    } else {
      for (; s < to; s += V::size) {
        const Ends ends = meet<stand>(s);
        move<stand>(s, ends, solve_at(s, ends));
      }
    }
  }

 private:
  using Ends = Met<V, Records<V>>;
  struct Moves {
    Mask<V> is_sound;
    V a, b;
  };

  // Register by register: g++ copies a whole struct of them through memory.
  [[gnu::always_inline]] static void hand_on(const Ends& from, Ends& to) noexcept {
    for (std::size_t n = 0; n < 4; ++n) {
      to.shift_a.at[n] = from.shift_a.at[n];
      to.shift_b.at[n] = from.shift_b.at[n];
      to.d.at[n] = from.d.at[n];
    }
    to.r2 = from.r2;
    to.path = from.path;
  }

  // The records of both ends, as they stand.
  template <Stand stand>
  [[gnu::always_inline]] void load_ends(const T* records, std::size_t s, Records<V>& of_a, Records<V>& of_b) const noexcept {
    const std::uint32_t* const a = terms_.a + s;
    const std::uint32_t* const b = terms_.b + s;
    if constexpr (stand == Stand::in_turn) {
      load_in_turn<V>(records, a, of_a, of_b);
    } else if constexpr (stand == Stand::side_by_side) {
      of_a = load_side_by_side<V>(records, a);
      of_b = load_side_by_side<V>(records, b);
    } else {
      of_a = gather_records<V>(records, a);
      of_b = gather_records<V>(records, b);
    }
  }
  template <Stand stand>
  [[gnu::always_inline]] void store_ends(T* records, std::size_t s, const Records<V>& of_a,
                                         const Records<V>& of_b) const noexcept {
    const std::uint32_t* const a = terms_.a + s;
    const std::uint32_t* const b = terms_.b + s;
    if constexpr (stand == Stand::in_turn) {
      store_in_turn<V>(records, a, of_a, of_b);
    } else if constexpr (stand == Stand::side_by_side) {
      store_side_by_side<V>(records, a, of_a);
      store_side_by_side<V>(records, b, of_b);
    } else {
      scatter_records(records, a, of_a);
      scatter_records(records, b, of_b);
    }
  }
  template <Stand stand>
  [[gnu::always_inline]] Records<V> between_ends(const T* records, std::size_t s) const noexcept {
    Records<V> a, b;
    load_ends<stand>(records, s, a, b);
    return b - a;
  }

  template <Stand stand>
  [[gnu::always_inline]] Ends meet(std::size_t s) const noexcept {
    Ends ends;
    load_ends<stand>(terms_.shift, s, ends.shift_a, ends.shift_b);
    const Records<V> moved = ends.shift_b - ends.shift_a;
    Records<V> apart;
    if constexpr (visit == Visit::again) {
      apart = load_records<V>(terms_.apart + record * s);
    } else {
      apart = between_ends<stand>(terms_.x, s);
      if (sweep_.origin == CountedFrom::step) apart = load_records<V>(terms_.from_origin + record * s) + apart;
      if (terms_.apart != nullptr) store_records(terms_.apart + record * s, apart);
    }
    ends.d = apart + moved;
    const Three<V> d = axes_of(ends.d);
    ends.r2 = dot<arithmetic>(d, d);
    ends.path = ends.r2;  // not read where nothing damps
    if constexpr (damping == Damping::along) ends.path = dot<arithmetic>(axes_of(path_of<stand>(s, moved)), d);
    return ends;
  }

  [[gnu::always_inline]] static Three<V> axes_of(const Records<V>& records) noexcept {
    const auto [x, y, z, nothing] = columns_of(records);
    return {{x, y, z}};
  }

  template <Stand stand>
  [[gnu::always_inline]] Records<V> path_of(std::size_t s, const Records<V>& moved) const noexcept {
    Records<V> u;
    if constexpr (visit == Visit::again) {
      u = load_records<V>(terms_.u + record * s);
    } else {
      u = between_ends<stand>(terms_.v, s);
      if (terms_.u != nullptr) store_records(terms_.u + record * s, u);
    }
    Records<V> path;
    for (std::size_t n = 0; n < 4; ++n) path.at[n] = multiply_add<arithmetic>(V(sweep_.h), u.at[n], moved.at[n]);
    return path;
  }

  [[gnu::always_inline]] Moves solve_at(std::size_t s, const Ends& ends) const noexcept {
    const auto [kappa, eta, inverse, w_a, w_b] = coefficients_of<V>(terms_, s);
    const V lambda = visit == Visit::first ? V(T(0)) : load_lanes<V>(sweep_.lambda + s);
    const Spring<V> spring{kappa, eta, load_lanes<V>(terms_.l + s), inverse};
    const auto [is_sound, more, t, y] = solve<damping, arithmetic>(spring, ends.r2, ends.path, lambda);
    if constexpr (visit == Visit::first) {
      if (sweep_.lambda != nullptr) store_lanes(sweep_.lambda + s, V(T(0)) + more);
    }
    return {is_sound, w_a * t, w_b * t};
  }

  // Lanes that are not sound are left alone: all others are rounded as they are without them.
  template <Stand stand>
  [[gnu::always_inline]] void move(std::size_t s, const Ends& ends, const Moves& by) const noexcept {
    const Records<V> t_a = records_of(by.a);
    const Records<V> t_b = records_of(by.b);
    Records<V> a, b;
    if (all_lanes<V>(by.is_sound)) {
      for (std::size_t n = 0; n < 4; ++n) {
        a.at[n] = subtract_at_once<arithmetic>(ends.shift_a.at[n], t_a.at[n], ends.d.at[n]);
        b.at[n] = add_at_once<arithmetic>(ends.shift_b.at[n], t_b.at[n], ends.d.at[n]);
      }
    } else {
      const V one(T(1));
      const Records<V> is_sound = records_of(select(by.is_sound, one, V(T(0))));
      for (std::size_t n = 0; n < 4; ++n) {
        const Mask<V> where = is_sound.at[n] == one;
        a.at[n] = subtract_product_where<arithmetic>(where, ends.shift_a.at[n], t_a.at[n], ends.d.at[n]);
        b.at[n] = add_product_where<arithmetic>(where, ends.shift_b.at[n], t_b.at[n], ends.d.at[n]);
      }
    }
    store_ends<stand>(terms_.shift, s, a, b);
  }

  const SweepTerms<T>& sweep_;
  const RangeTerms<T>& terms_;
};

template <class V, Damping damping, Visit visit, Arithmetic arithmetic>
void sweep_range(const SweepTerms<Scalar<V>>& sweep, std::size_t from, std::size_t to) noexcept {
  RangeSweep<V, damping, visit, arithmetic>(sweep).run(from, to);
}

// Calls with the template arguments that the terms ask for.
template <class Call>
void by_kind(Damping damping, const Call& call) noexcept {
  if (damping == Damping::along) return call.template operator()<Damping::along>();
  call.template operator()<Damping::none>();
}
template <class Call>
void by_kind(Damping damping, Visit visit, const Call& call) noexcept {
  by_kind(damping, [&]<Damping d>() {
    if (visit == Visit::first) return call.template operator()<d, Visit::first>();
    call.template operator()<d, Visit::again>();
  });
}

template <class V, Arithmetic arithmetic>
void sweep_strands(const SweepTerms<Scalar<V>>& sweep, const WorkColumns<Scalar<V>>& work, Visit visit, std::size_t from,
                   std::size_t to) noexcept {
  if (from == to) return;  // of a sheet without springs there are no strands to point to
  const auto sweep_by = [&]<Damping damping, Visit v>() {
    const std::ptrdiff_t step = from < to ? 1 : -1;
    const Strand* strand = from < to ? sweep.strands + from : sweep.strands + from - 1;
    const Strand* const end = from < to ? sweep.strands + to : sweep.strands + to - 1;
    while (strand != end) {
      const Strand* next = strand;
      while (next != end && next->turn == strand->turn) next += step;
      if (sweep.families != nullptr) {
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

template <class V, Arithmetic arithmetic>
void sweep_ranges(const SweepTerms<Scalar<V>>& sweep, Visit visit, std::size_t from, std::size_t to) noexcept {
  const std::uint32_t* const first = sweep.ranges.first;
  by_kind(sweep.damping, visit, [&]<Damping damping, Visit v>() {
    for (std::size_t n = from; n < to; ++n) sweep_range<V, damping, v, arithmetic>(sweep, first[n], first[n + 1]);
    for (std::size_t n = from; n > to; --n) sweep_range<V, damping, v, arithmetic>(sweep, first[n - 1], first[n]);
  });
}

template <class V>
void keep_from_origin(const SweepTerms<Scalar<V>>& sweep, std::size_t from, std::size_t to) noexcept {
  const RangeTerms<Scalar<V>>& terms = sweep.ranges;
  for (std::size_t s = terms.first[from]; s < terms.first[to]; s += V::size) {
    const Records<V> apart = gather_records<V>(terms.x, terms.b + s) - gather_records<V>(terms.x, terms.a + s);
    store_records(terms.from_origin + record * s, apart);
  }
}

// Where 16 records in a row begin.
inline constexpr std::array<std::uint32_t, slice> in_a_row{0, 4, 8, 12, 16, 20, 24, 28, 32, 36, 40, 44, 48, 52, 56, 60};

template <class V>
void columns_to_records(const std::array<const Scalar<V>*, 3>& columns, Scalar<V>* records, std::size_t from,
                        std::size_t to) noexcept {
  for (std::size_t i = from; i < to; i += V::size) {
    const auto [x, y, z] = load_three<V>(columns, i).at;
    scatter_records(records + record * i, in_a_row.data(), records_of(std::array<V, 4>{x, y, z, V(Scalar<V>(0))}));
  }
}
template <class V>
void records_to_columns(const Scalar<V>* records, const std::array<Scalar<V>*, 3>& columns, std::size_t from,
                        std::size_t to) noexcept {
  for (std::size_t i = from; i < to; i += V::size) {
    const auto [x, y, z, nothing] = columns_of(gather_records<V>(records + record * i, in_a_row.data()));
    store_three<V>(columns, i, {{x, y, z}});
  }
}

template <class V, Arithmetic arithmetic>
void take_shift(const WorkColumns<Scalar<V>>& work, Scalar<V> of_x, Scalar<V> of_v, std::size_t from, std::size_t to) noexcept {
  const V zero(Scalar<V>(0));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = from; i < to; i += V::size) {
      const V shift = load_lanes<V>(work.shift[axis] + i);
      const V x = load_lanes<V>(work.x[axis] + i);
      const V v = load_lanes<V>(work.v[axis] + i);
      if (of_x != 0) store_lanes(work.x[axis] + i, multiply_add<arithmetic>(V(of_x), shift, x));
      store_lanes(work.v[axis] + i, multiply_add<arithmetic>(V(of_v), shift, v));
      store_lanes(work.shift[axis] + i, zero);
    }
  }
}

template <class V>
void move_origin(const std::array<Scalar<V>*, 3>& origin, const std::array<Scalar<V>*, 3>& x, std::size_t from,
                 std::size_t to) noexcept {
  const V zero(Scalar<V>(0));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = from; i < to; i += V::size) {
      store_lanes(origin[axis] + i, load_lanes<V>(origin[axis] + i) + load_lanes<V>(x[axis] + i));
      store_lanes(x[axis] + i, zero);
    }
  }
}

// The factors stand in registers: stores may alias the terms.
template <class V, Arithmetic arithmetic>
void begin_sweeps(const AlphaTerms<Scalar<V>>& alpha, const WorkColumns<Scalar<V>>& work, std::size_t from,
                  std::size_t to) noexcept {
  const V P_v(alpha.P_v);
  const V P_a(alpha.P_a);
  const V u_a(alpha.u_a);
  const Damping damping = alpha.damping;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Scalar<V>* const shift = work.shift[axis];
    Scalar<V>* const v_next = work.v_next[axis];
    for (std::size_t i = from; i < to; i += V::size) {
      const V v = load_lanes<V>(work.v[axis] + i);
      const V a = load_lanes<V>(work.a[axis] + i);
      store_lanes(shift + i, multiply_add<arithmetic>(P_a, a, P_v * v));
      if (damping == Damping::along) store_lanes(v_next + i, multiply_add<arithmetic>(u_a, a, v));
    }
  }
}

template <class V, Arithmetic arithmetic>
void end_sweeps(const AlphaTerms<Scalar<V>>& alpha, const WorkColumns<Scalar<V>>& work, std::size_t from,
                std::size_t to) noexcept {
  const V P_v(alpha.P_v);
  const V P_a(alpha.P_a);
  const V b_S(alpha.b_S);
  const V b_a(alpha.b_a);
  const V v_a(alpha.v_a);
  const V v_b(alpha.v_b);
  const V x_b(alpha.x_b);
  const V zero(Scalar<V>(0));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Scalar<V>* const x_column = work.x[axis];
    Scalar<V>* const v_column = work.v[axis];
    Scalar<V>* const a_column = work.a[axis];
    const Scalar<V>* const shift = work.shift[axis];
    for (std::size_t i = from; i < to; i += V::size) {
      const V x = load_lanes<V>(x_column + i);
      const V v = load_lanes<V>(v_column + i);
      const V a = load_lanes<V>(a_column + i);
      const V S = load_lanes<V>(shift + i) - multiply_add<arithmetic>(P_a, a, P_v * v);
      const V b = subtract_product<arithmetic>(b_S * S, b_a, a);
      store_lanes(x_column + i, multiply_add<arithmetic>(x_b, b - a, x));
      store_lanes(v_column + i, v + multiply_add<arithmetic>(v_b, b, v_a * a));
      store_lanes(a_column + i, select(b - b == zero, b, zero));  // NaN must not enter the next sub-step
    }
  }
}

}  // namespace
}  // namespace dvdx
