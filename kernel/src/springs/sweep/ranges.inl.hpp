// Sweeps over a list's springs, range by range, in records, wide. The scalar twin: sequential_reference.hpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "springs/sweep/sequential.inl.hpp"

namespace dvdx {
namespace {

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

// c + a b and c - a b, rounded as by the _where functions of simd/registers.hpp: only fast arithmetic rounds once.
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

// Records are transposed to lanes only where a spring's numbers meet: d for its length, and t on the way back.
template <class V, Damping damping, Visit visit, Arithmetic arithmetic>
class RangeSweep {
 public:
  using T = Scalar<V>;

  explicit RangeSweep(const SweepTerms<T>& sweep) noexcept : sweep_(sweep), terms_(sweep.ranges) {}

  // Whether the next springs' ends, which the present springs do not share, are met while these are solved. It gains 8 to 10 %
  // on AVX-512 in float32, 0 to 3 % where roots are estimates. Elsewhere registers are too few: it lost 2 to 5 %.
  static constexpr bool meets_ahead = sizeof(V) == 64 && sizeof(T) == 4;

  // Springs of one layout follow each other.
  [[gnu::always_inline]] void run(std::size_t from, std::size_t to) const noexcept {
    if constexpr (!holds_every_fourth<V>) {
      run_alike<RecordLayout::anywhere>(from, to);
    } else {
      for (std::size_t end = from; from < to; from = end) {
        const RecordLayout layout = terms_.layout[from / slice];
        while (end < to && terms_.layout[end / slice] == layout) end += slice;
        if (layout == RecordLayout::side_by_side) {
          run_alike<RecordLayout::side_by_side>(from, end);
        } else if (layout == RecordLayout::in_turn) {
          run_alike<RecordLayout::in_turn>(from, end);
        } else {
          run_alike<RecordLayout::anywhere>(from, end);
        }
      }
    }
  }

  template <RecordLayout layout>
  [[gnu::always_inline]] void run_alike(std::size_t from, std::size_t to) const noexcept {
    if (from == to) return;
    std::size_t s = from;
    if constexpr (meets_ahead) {
      Ends ends = meet<layout>(s);
      for (; s + V::size < to; s += V::size) {
        const Moves moves = solve_at(s, ends);
        const Ends next = meet<layout>(s + V::size);
        move<layout>(s, ends, moves);
        hand_on(next, ends);
      }
      move<layout>(s, ends, solve_at(s, ends));
    } else {
      for (; s < to; s += V::size) {
        const Ends ends = meet<layout>(s);
        move<layout>(s, ends, solve_at(s, ends));
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

  // Loads the records of both ends, by their layout.
  template <RecordLayout layout>
  [[gnu::always_inline]] void load_ends(const T* records, std::size_t s, Records<V>& of_a, Records<V>& of_b) const noexcept {
    const std::uint32_t* const a = terms_.a + s;
    const std::uint32_t* const b = terms_.b + s;
    if constexpr (layout == RecordLayout::in_turn) {
      load_in_turn<V>(records, a, of_a, of_b);
    } else if constexpr (layout == RecordLayout::side_by_side) {
      of_a = load_side_by_side<V>(records, a);
      of_b = load_side_by_side<V>(records, b);
    } else {
      of_a = gather_records<V>(records, a);
      of_b = gather_records<V>(records, b);
    }
  }
  template <RecordLayout layout>
  [[gnu::always_inline]] void store_ends(T* records, std::size_t s, const Records<V>& of_a,
                                         const Records<V>& of_b) const noexcept {
    const std::uint32_t* const a = terms_.a + s;
    const std::uint32_t* const b = terms_.b + s;
    if constexpr (layout == RecordLayout::in_turn) {
      store_in_turn<V>(records, a, of_a, of_b);
    } else if constexpr (layout == RecordLayout::side_by_side) {
      store_side_by_side<V>(records, a, of_a);
      store_side_by_side<V>(records, b, of_b);
    } else {
      scatter_records(records, a, of_a);
      scatter_records(records, b, of_b);
    }
  }
  template <RecordLayout layout>
  [[gnu::always_inline]] Records<V> between_ends(const T* records, std::size_t s) const noexcept {
    Records<V> a, b;
    load_ends<layout>(records, s, a, b);
    return b - a;
  }

  template <RecordLayout layout>
  [[gnu::always_inline]] Ends meet(std::size_t s) const noexcept {
    Ends ends;
    load_ends<layout>(terms_.shift, s, ends.shift_a, ends.shift_b);
    const Records<V> moved = ends.shift_b - ends.shift_a;
    Records<V> apart;
    if constexpr (visit == Visit::again) {
      apart = load_records<V>(terms_.apart + record * s);
    } else {
      apart = between_ends<layout>(terms_.x, s);
      if (sweep_.origin == CountedFrom::step) apart = load_records<V>(terms_.from_origin + record * s) + apart;
      if (terms_.apart != nullptr) store_records(terms_.apart + record * s, apart);
    }
    ends.d = apart + moved;
    const Three<V> d = axes_of(ends.d);
    ends.r2 = dot<arithmetic>(d, d);
    ends.path = ends.r2;  // not read without damping
    if constexpr (damping == Damping::along) ends.path = dot<arithmetic>(axes_of(path_of<layout>(s, moved)), d);
    return ends;
  }

  [[gnu::always_inline]] static Three<V> axes_of(const Records<V>& records) noexcept {
    const auto [x, y, z, nothing] = columns_of(records);
    return {{x, y, z}};
  }

  template <RecordLayout layout>
  [[gnu::always_inline]] Records<V> path_of(std::size_t s, const Records<V>& moved) const noexcept {
    Records<V> u;
    if constexpr (visit == Visit::again) {
      u = load_records<V>(terms_.u + record * s);
    } else {
      u = between_ends<layout>(terms_.v, s);
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

  // Lanes that are not sound stay as they are. All others round as they do without them.
  template <RecordLayout layout>
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
    store_ends<layout>(terms_.shift, s, a, b);
  }

  const SweepTerms<T>& sweep_;
  const RangeTerms<T>& terms_;
};

template <class V, Damping damping, Visit visit, Arithmetic arithmetic>
void sweep_range(const SweepTerms<Scalar<V>>& sweep, std::size_t from, std::size_t to) noexcept {
  RangeSweep<V, damping, visit, arithmetic>(sweep).run(from, to);
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

// The positions of 16 consecutive records.
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

}  // namespace
}  // namespace dvdx
