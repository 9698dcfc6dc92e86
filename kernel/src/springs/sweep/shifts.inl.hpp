// The operations before and after sweeps, wide: by theta, and by generalized alpha. The scalar twin: sequential_reference.hpp.
#pragma once

#include <array>
#include <cstddef>

#include "springs/pull.inl.hpp"

namespace dvdx {
namespace {

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

// The factors are copied to registers, as stores may alias the terms.
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
      store_lanes(a_column + i, select(b - b == zero, b, zero));  // only finite numbers enter the next sub-step
    }
  }
}

}  // namespace
}  // namespace dvdx
