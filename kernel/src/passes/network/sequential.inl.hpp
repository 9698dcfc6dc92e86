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

template <class V, class Columns>
[[gnu::always_inline]] inline Three<V> gather_three(const Columns& columns, const std::int32_t* index) noexcept {
  return {{gather_lanes<V>(columns[0], index), gather_lanes<V>(columns[1], index), gather_lanes<V>(columns[2], index)}};
}

template <class V, Damping damping, CountedFrom origin, Visit visit, Arithmetic arithmetic>
void sweep_colour_by(const SweepTerms<Scalar<V>>& sweep, const WorkColumns<Scalar<V>>& work, std::size_t from,
                     std::size_t to) noexcept {
  using T = Scalar<V>;
  const auto load = [](const T* column, std::size_t s) { return load_lanes<V>(column + s); };
  for (std::size_t s = from; s < to; s += V::size) {
    const std::int32_t* const a = sweep.a + s;
    const std::int32_t* const b = sweep.b + s;
    Three<V> apart;
    if constexpr (visit == Visit::again) {
      apart = kept_apart<V>(sweep, s);
    } else {
      apart = gather_three<V>(work.x, b) - gather_three<V>(work.x, a);
      if constexpr (origin == CountedFrom::step)
        apart = (gather_three<V>(work.origin, b) - gather_three<V>(work.origin, a)) + apart;
      if (sweep.apart[0] != nullptr) store_three<V>(sweep.apart, s, apart);
    }
    Three<V> u = apart;  // not read where nothing damps
    if constexpr (damping == Damping::along) u = gather_three<V>(work.v, b) - gather_three<V>(work.v, a);
    const Spring<V> spring{load(sweep.kappa, s),   load(sweep.eta, s), load(sweep.l, s),
                           load(sweep.inverse, s), load(sweep.w_a, s), load(sweep.w_b, s)};
    const Shifts<V> before{gather_three<V>(work.shift, a), gather_three<V>(work.shift, b)};
    V lambda = visit == Visit::first ? V(T(0)) : load(sweep.lambda, s);
    const Shifts<V> after = visited<damping, arithmetic>(spring, apart, before, u, V(sweep.h), lambda);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      scatter_lanes<V>(work.shift[axis], a, after.a[axis]);
      scatter_lanes<V>(work.shift[axis], b, after.b[axis]);
    }
    store_lanes(sweep.lambda + s, lambda);
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
void sweep_colour(const SweepTerms<Scalar<V>>& sweep, const WorkColumns<Scalar<V>>& work, Visit visit, std::size_t from,
                  std::size_t to) noexcept {
  by_kind(sweep.damping, sweep.origin, visit, [&]<Damping damping, CountedFrom origin, Visit v>() {
    sweep_colour_by<V, damping, origin, v, arithmetic>(sweep, work, from, to);
  });
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
