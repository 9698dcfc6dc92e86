// Gauss-Seidel sweeps over springs, wide. The scalar twin: sequential_reference.hpp; the method: sequential.hpp.
#pragma once

#include "passes/network/pull.inl.hpp"

namespace dvdx {
namespace {

template <class V>
struct Ends {  // x_b - x_a, shift_b - shift_a, v_b - v_a
  Three<V> x, shift, v;
};

template <class V>
struct Compliance {
  V kappa, eta, l, inverse;
};

// How much more of lambda the spring asks for, times 1/r: the shift of b in units of d and w_b.
template <class V, Damping damping, Arithmetic arithmetic>
V impulse(const Ends<V>& ends, const Three<V>& d, const Compliance<V>& spring, V h, V& lambda) noexcept {
  using T = Scalar<V>;
  const auto [is_long, r2, y] = length<arithmetic>(d);
  Mask<V> is_sound = is_long;
  V g = spring.kappa * subtract_product<arithmetic>(spring.l, r2, y);  // -kappa C
  if constexpr (damping == Damping::along) {
    const V moved = dot<arithmetic>(multiply_add<arithmetic>(h, ends.v, ends.shift), d);
    is_sound = is_sound & (magnitude(moved) < V(most_square<T>));
    g = subtract_product<arithmetic>(g, spring.eta * y, moved);
  }
  const V more = select<V>(is_sound, (g - lambda) * spring.inverse, V(T(0)));
  lambda = lambda + more;
  return more * y;
}

template <class V, Damping damping, Origin origin, Visit visit, Arithmetic arithmetic>
void sweep_strand(const SweepTerms<Scalar<V>>& sweep, const Sheet<Scalar<V>>& sheet, const Strand& strand) noexcept {
  using T = Scalar<V>;
  const StrandFamily<T>& family = sweep.families[strand.family];
  const V h(sweep.h);
  for (std::size_t k = 0; k < strand.count; k += V::size) {
    const std::size_t a = strand.a + k;
    const std::size_t b = strand.b + k;
    const Three<V> shift_a = load_three<V>(sheet.shift, a);
    const Three<V> shift_b = load_three<V>(sheet.shift, b);
    Ends<V> ends;
    ends.shift = shift_b - shift_a;
    ends.x = load_three<V>(sheet.x, b) - load_three<V>(sheet.x, a);
    if constexpr (origin == Origin::step) {
      ends.x = (load_three<V>(sheet.origin, b) - load_three<V>(sheet.origin, a)) + ends.x;
    }
    if constexpr (damping == Damping::along) ends.v = load_three<V>(sheet.v, b) - load_three<V>(sheet.v, a);
    const Compliance<V> spring{V(family.kappa), V(family.eta), V(family.l), load_lanes<V>(sweep.inverse + strand.springs + k)};
    V lambda = visit == Visit::first ? V(T(0)) : load_lanes<V>(sweep.lambda + strand.springs + k);
    const Three<V> d = ends.x + ends.shift;
    const V t = impulse<V, damping, arithmetic>(ends, d, spring, h, lambda);
    const V t_a = load_lanes<V>(sheet.w + a) * t;
    const V t_b = load_lanes<V>(sheet.w + b) * t;
    // A select, because 0 times a bad particle's d is not 0.
    Three<V> to_a = select(t != V(T(0)), subtract_product<arithmetic>(shift_a, t_a, d), shift_a);
    Three<V> to_b = select(t != V(T(0)), multiply_add<arithmetic>(t_b, d, shift_b), shift_b);
    if (k + V::size > strand.count) {  // what lies beyond the strand belongs to others
      const Mask<V> is_spring = first_lanes<V>(strand.count - k);
      to_a = select(is_spring, to_a, shift_a);
      to_b = select(is_spring, to_b, shift_b);
    }
    store_three<V>(sheet.shift, a, to_a);
    store_three<V>(sheet.shift, b, to_b);
    store_lanes(sweep.lambda + strand.springs + k, lambda);
  }
}

template <class V, Damping damping, Origin origin, Visit visit, Arithmetic arithmetic>
void sweep_colour_by(const SweepTerms<Scalar<V>>& sweep, const Sheet<Scalar<V>>& sheet, std::size_t from,
                     std::size_t to) noexcept {
  using T = Scalar<V>;
  const auto gather_three = [](const auto& columns, const std::int32_t* index) {
    return Three<V>{
        {gather_lanes<V>(columns[0], index), gather_lanes<V>(columns[1], index), gather_lanes<V>(columns[2], index)}};
  };
  for (std::size_t s = from; s < to; s += V::size) {
    const std::int32_t* const a = sweep.a + s;
    const std::int32_t* const b = sweep.b + s;
    const Three<V> shift_a = gather_three(sheet.shift, a);
    const Three<V> shift_b = gather_three(sheet.shift, b);
    Ends<V> ends;
    ends.shift = shift_b - shift_a;
    ends.x = gather_three(sheet.x, b) - gather_three(sheet.x, a);
    if constexpr (origin == Origin::step) ends.x = (gather_three(sheet.origin, b) - gather_three(sheet.origin, a)) + ends.x;
    if constexpr (damping == Damping::along) ends.v = gather_three(sheet.v, b) - gather_three(sheet.v, a);
    const Compliance<V> spring{load_lanes<V>(sweep.kappa + s), load_lanes<V>(sweep.eta + s), load_lanes<V>(sweep.l + s),
                               load_lanes<V>(sweep.inverse + s)};
    V lambda = visit == Visit::first ? V(T(0)) : load_lanes<V>(sweep.lambda + s);
    const Three<V> d = ends.x + ends.shift;
    const V t = impulse<V, damping, arithmetic>(ends, d, spring, V(sweep.h), lambda);
    const V t_a = gather_lanes<V>(sheet.w, a) * t;
    const V t_b = gather_lanes<V>(sheet.w, b) * t;
    const Three<V> to_a = select(t != V(T(0)), subtract_product<arithmetic>(shift_a, t_a, d), shift_a);
    const Three<V> to_b = select(t != V(T(0)), multiply_add<arithmetic>(t_b, d, shift_b), shift_b);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      scatter_lanes<V>(sheet.shift[axis], a, to_a[axis]);
      scatter_lanes<V>(sheet.shift[axis], b, to_b[axis]);
    }
    store_lanes(sweep.lambda + s, lambda);
  }
}

// Calls with the template arguments that the terms ask for.
template <class Call>
void by_kind(Damping damping, Origin origin, Visit visit, const Call& call) noexcept {
  const auto with_visit = [&]<Damping d, Origin o>() {
    if (visit == Visit::first) return call.template operator()<d, o, Visit::first>();
    call.template operator()<d, o, Visit::again>();
  };
  const auto with_origin = [&]<Damping d>() {
    if (origin == Origin::step) return with_visit.template operator()<d, Origin::step>();
    with_visit.template operator()<d, Origin::zero>();
  };
  if (damping == Damping::along) return with_origin.template operator()<Damping::along>();
  with_origin.template operator()<Damping::none>();
}

template <class V, Arithmetic arithmetic>
void sweep_strands(const SweepTerms<Scalar<V>>& sweep, const Sheet<Scalar<V>>& sheet, Visit visit, std::size_t from,
                   std::size_t to) noexcept {
  by_kind(sweep.damping, sweep.origin, visit, [&]<Damping damping, Origin origin, Visit v>() {
    for (std::size_t n = from; n < to; ++n) sweep_strand<V, damping, origin, v, arithmetic>(sweep, sheet, sweep.strands[n]);
    for (std::size_t n = from; n > to; --n) sweep_strand<V, damping, origin, v, arithmetic>(sweep, sheet, sweep.strands[n - 1]);
  });
}

template <class V, Arithmetic arithmetic>
void sweep_colour(const SweepTerms<Scalar<V>>& sweep, const Sheet<Scalar<V>>& sheet, Visit visit, std::size_t from,
                  std::size_t to) noexcept {
  by_kind(sweep.damping, sweep.origin, visit, [&]<Damping damping, Origin origin, Visit v>() {
    sweep_colour_by<V, damping, origin, v, arithmetic>(sweep, sheet, from, to);
  });
}

template <class V, Arithmetic arithmetic>
void take_shift(const Sheet<Scalar<V>>& sheet, Scalar<V> of_x, Scalar<V> of_v, std::size_t from, std::size_t to) noexcept {
  const V zero(Scalar<V>(0));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = from; i < to; i += V::size) {
      const V shift = load_lanes<V>(sheet.shift[axis] + i);
      const V x = load_lanes<V>(sheet.x[axis] + i);
      const V v = load_lanes<V>(sheet.v[axis] + i);
      if (of_x != 0) store_lanes(sheet.x[axis] + i, multiply_add<arithmetic>(V(of_x), shift, x));
      store_lanes(sheet.v[axis] + i, multiply_add<arithmetic>(V(of_v), shift, v));
      store_lanes(sheet.shift[axis] + i, zero);
    }
  }
}

}  // namespace
}  // namespace dvdx
