// Gauss-Seidel sweeps over springs, wide. The scalar twin: sequential_reference.hpp; the method: sequential.hpp.
#pragma once

#include "passes/network/pull.inl.hpp"

namespace dvdx {
namespace {

template <class V>
struct Spring {
  V kappa, eta, l, inverse, w_a, w_b;
};

template <class V>
struct Shifts {
  Three<V> a, b;
};

// Moves the ends' shifts by what more of lambda the spring asks for; u = v_b - v_a.
template <Damping damping, Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline Shifts<V> visited(const Spring<V>& spring, const Three<V>& apart, const Shifts<V>& shift,
                                                const Three<V>& u, V h, V& lambda) noexcept {
  using T = Scalar<V>;
  const Three<V> moved = shift.b - shift.a;
  const Three<V> d = apart + moved;
  const auto [is_long, r2, y] = length<arithmetic>(d);
  Mask<V> is_sound = is_long;
  V g = spring.kappa * subtract_product<arithmetic>(spring.l, r2, y);  // -kappa C
  if constexpr (damping == Damping::along) {
    const V path = dot<arithmetic>(multiply_add<arithmetic>(h, u, moved), d);
    is_sound = is_sound & (magnitude(path) < V(most_square<T>));
    g = subtract_product<arithmetic>(g, spring.eta * y, path);
  }
  const V more = product_where<V>(is_sound, g - lambda, spring.inverse);
  lambda = lambda + more;
  const V t = more * y;
  return {shift.a - product_where(is_sound, spring.w_a * t, d), shift.b + product_where(is_sound, spring.w_b * t, d)};
}

template <class V>
[[gnu::always_inline]] inline Three<V> kept_apart(const SweepTerms<Scalar<V>>& sweep, std::size_t s) noexcept {
  return {{load_lanes<V>(sweep.apart[0] + s), load_lanes<V>(sweep.apart[1] + s), load_lanes<V>(sweep.apart[2] + s)}};
}

// (Two independent strands at a time, to hide the latency of one spring's chain, gained 5 % on AVX-512, 15 % on SSE2.)
template <class V, Damping damping, CountedFrom origin, Visit visit, Arithmetic arithmetic>
void sweep_strand(const SweepTerms<Scalar<V>>& sweep, const WorkColumns<Scalar<V>>& work, const Strand& strand) noexcept {
  using T = Scalar<V>;
  const StrandFamily<T>& family = sweep.families[strand.family];
  const V kappa(family.kappa);
  const V eta(family.eta);
  const V l(family.l);
  const V h(sweep.h);
  for (std::size_t k = 0; k < strand.count; k += V::size) {
    const std::size_t a = strand.a + k;
    const std::size_t b = strand.b + k;
    const std::size_t s = strand.springs + k;
    Three<V> apart;
    if constexpr (visit == Visit::again) {
      apart = kept_apart<V>(sweep, s);
    } else {
      apart = load_three<V>(work.x, b) - load_three<V>(work.x, a);
      if constexpr (origin == CountedFrom::step) {
        apart = (load_three<V>(work.origin, b) - load_three<V>(work.origin, a)) + apart;
      }
      if (sweep.apart[0] != nullptr) store_three<V>(sweep.apart, s, apart);
    }
    Three<V> u = apart;  // not read where nothing damps
    if constexpr (damping == Damping::along) u = load_three<V>(work.v, b) - load_three<V>(work.v, a);
    const Spring<V> spring{
        kappa, eta, l, load_lanes<V>(sweep.inverse + s), load_lanes<V>(work.w + a), load_lanes<V>(work.w + b)};
    const Shifts<V> before{load_three<V>(work.shift, a), load_three<V>(work.shift, b)};
    V lambda = visit == Visit::first ? V(T(0)) : load_lanes<V>(sweep.lambda + s);
    Shifts<V> after = visited<damping, arithmetic>(spring, apart, before, u, h, lambda);
    if (k + V::size > strand.count) {  // what lies beyond the strand belongs to others
      const Mask<V> is_spring = first_lanes<V>(strand.count - k);
      after = {select(is_spring, after.a, before.a), select(is_spring, after.b, before.b)};
    }
    store_three<V>(work.shift, a, after.a);
    store_three<V>(work.shift, b, after.b);
    store_lanes(sweep.lambda + s, lambda);
  }
}

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

template <class V>
[[gnu::always_inline]] inline Records<V> product_where(const Mask<V>& where, const Records<V>& s,
                                                       const Records<V>& d) noexcept {
  const V one(Scalar<V>(1));
  const Records<V> is_there = records_of(select(where, one, V(Scalar<V>(0))));
  Records<V> product;
  for (std::size_t n = 0; n < 4; ++n) product.at[n] = product_where<V>(is_there.at[n] == one, s.at[n], d.at[n]);
  return product;
}

// As visited(), but records are turned into lanes only where a spring's numbers meet: d for its length, and t on the way back.
template <class V, Damping damping, CountedFrom origin, Visit visit, Arithmetic arithmetic>
void sweep_range(const SweepTerms<Scalar<V>>& sweep, std::size_t from, std::size_t to) noexcept {
  using T = Scalar<V>;
  const RangeTerms<T>& terms = sweep.ranges;
  for (std::size_t s = from; s < to; s += V::size) {
    const std::uint32_t* const a = terms.a + s;
    const std::uint32_t* const b = terms.b + s;
    const Records<V> shift_a = gather_records<V>(terms.shift, a);
    const Records<V> shift_b = gather_records<V>(terms.shift, b);
    const Records<V> moved = shift_b - shift_a;
    Records<V> apart;
    if constexpr (visit == Visit::again) {
      apart = load_records<V>(terms.apart + record * s);
    } else {
      apart = gather_records<V>(terms.x, b) - gather_records<V>(terms.x, a);
      if constexpr (origin == CountedFrom::step) apart = load_records<V>(terms.from_origin + record * s) + apart;
      if (terms.apart != nullptr) store_records(terms.apart + record * s, apart);
    }
    const Records<V> d = apart + moved;
    const auto [d_x, d_y, d_z, no_axis] = columns_of(d);
    const Three<V> axes{{d_x, d_y, d_z}};
    const auto [kappa, eta, inverse, w_a, w_b] = coefficients_of<V>(terms, s);
    const auto [is_long, r2, y] = length<arithmetic>(axes);
    Mask<V> is_sound = is_long;
    V g = kappa * subtract_product<arithmetic>(load_lanes<V>(terms.l + s), r2, y);  // -kappa C
    if constexpr (damping == Damping::along) {
      Records<V> u;
      if constexpr (visit == Visit::again) {
        u = load_records<V>(terms.u + record * s);
      } else {
        u = gather_records<V>(terms.v, b) - gather_records<V>(terms.v, a);
        if (terms.u != nullptr) store_records(terms.u + record * s, u);
      }
      Records<V> path_of;
      for (std::size_t n = 0; n < 4; ++n) path_of.at[n] = multiply_add<arithmetic>(V(sweep.h), u.at[n], moved.at[n]);
      const auto [path_x, path_y, path_z, no_path] = columns_of(path_of);
      const V path = dot<arithmetic>(Three<V>{{path_x, path_y, path_z}}, axes);
      is_sound = is_sound & (magnitude(path) < V(most_square<T>));
      g = subtract_product<arithmetic>(g, eta * y, path);
    }
    if constexpr (visit == Visit::again) g = g - load_lanes<V>(sweep.lambda + s);
    const V more = product_where<V>(is_sound, g, inverse);
    if constexpr (visit == Visit::first) store_lanes(sweep.lambda + s, V(T(0)) + more);
    const V t = more * y;
    const Records<V> t_a = records_of(w_a * t);
    const Records<V> t_b = records_of(w_b * t);
    Records<V> way_a = t_a * d;
    Records<V> way_b = t_b * d;
    if (!all_lanes<V>(is_sound)) {
      way_a = product_where(is_sound, t_a, d);
      way_b = product_where(is_sound, t_b, d);
    }
    scatter_records(terms.shift, a, shift_a - way_a);
    scatter_records(terms.shift, b, shift_b + way_b);
  }
}

// Calls with the template arguments that the terms ask for.
template <class Call>
void by_kind(Damping damping, CountedFrom origin, Visit visit, const Call& call) noexcept {
  const auto with_visit = [&]<Damping d, CountedFrom o>() {
    if (visit == Visit::first) return call.template operator()<d, o, Visit::first>();
    call.template operator()<d, o, Visit::again>();
  };
  const auto with_origin = [&]<Damping d>() {
    if (origin == CountedFrom::step) return with_visit.template operator()<d, CountedFrom::step>();
    with_visit.template operator()<d, CountedFrom::zero>();
  };
  if (damping == Damping::along) return with_origin.template operator()<Damping::along>();
  with_origin.template operator()<Damping::none>();
}

template <class V, Arithmetic arithmetic>
void sweep_strands(const SweepTerms<Scalar<V>>& sweep, const WorkColumns<Scalar<V>>& work, Visit visit, std::size_t from,
                   std::size_t to) noexcept {
  by_kind(sweep.damping, sweep.origin, visit, [&]<Damping damping, CountedFrom origin, Visit v>() {
    for (std::size_t n = from; n < to; ++n) sweep_strand<V, damping, origin, v, arithmetic>(sweep, work, sweep.strands[n]);
    for (std::size_t n = from; n > to; --n) sweep_strand<V, damping, origin, v, arithmetic>(sweep, work, sweep.strands[n - 1]);
  });
}

template <class V, Arithmetic arithmetic>
void sweep_ranges(const SweepTerms<Scalar<V>>& sweep, Visit visit, std::size_t from, std::size_t to) noexcept {
  const std::uint32_t* const first = sweep.ranges.first;
  by_kind(sweep.damping, sweep.origin, visit, [&]<Damping damping, CountedFrom origin, Visit v>() {
    for (std::size_t n = from; n < to; ++n) sweep_range<V, damping, origin, v, arithmetic>(sweep, first[n], first[n + 1]);
    for (std::size_t n = from; n > to; --n) sweep_range<V, damping, origin, v, arithmetic>(sweep, first[n - 1], first[n]);
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
      store_lanes(a_column + i, select(b - b == zero, b, zero));  // what is not finite is not remembered
    }
  }
}

}  // namespace
}  // namespace dvdx
