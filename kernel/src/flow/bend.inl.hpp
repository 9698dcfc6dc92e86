// Responses within a step, wide. The derivation stands in bend.hpp, the scalar twin in bend_reference.hpp.
#pragma once

#include <cstddef>

#include "flow/terms.hpp"
#include "simd/lanes.hpp"
#include "simd/three.inl.hpp"

namespace dvdx {
namespace {

template <class V>
struct Responses {
  Three<V> P0, P1, P2;
  Three<V> P3, P4, P5;  // where forces depend on time
};

template <class V>
Responses<V> select(const Mask<V>& where, const Responses<V>& a, const Responses<V>& b) noexcept {
  return {select(where, a.P0, b.P0), select(where, a.P1, b.P1), select(where, a.P2, b.P2),
          select(where, a.P3, b.P3), select(where, a.P4, b.P4), select(where, a.P5, b.P5)};
}

// D1, D2, D3 of bend.hpp, m: derivatives of h^2 f by the part of the step.
template <class V>
struct Drive {
  Three<V> D1, D2, D3;
};

// The responses of a register's particles.
template <class V, Arithmetic arithmetic>
class Bending {
  using T = Scalar<V>;

 public:
  // Particles side by side, from index i of the plan's columns on.
  Bending(const Bend<T>& bend, std::size_t i) noexcept : bend_(bend) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      w[axis] = bend.w_each[axis] != nullptr ? load_lanes<V>(bend.w_each[axis] + i) : V(bend.w[axis]);
      q[axis] = bend.q_each[axis] != nullptr ? load_lanes<V>(bend.q_each[axis] + i) : V(bend.q[axis]);
    }
    make_series();
  }
  // The particles first + at[0], first + at[1], ...
  Bending(const Bend<T>& bend, std::size_t first, const std::size_t* at) noexcept : bend_(bend) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      w[axis] = bend.w_each[axis] != nullptr ? gathered(bend.w_each[axis] + first, at) : V(bend.w[axis]);
      q[axis] = bend.q_each[axis] != nullptr ? gathered(bend.q_each[axis] + first, at) : V(bend.q[axis]);
    }
    make_series();
  }

  [[nodiscard]] Responses<V> operator()(V phi) const noexcept {
    const V zero(T(0));
    Responses<V> all{three<V>(zero), three<V>(zero), three<V>(zero), three<V>(zero), three<V>(zero), three<V>(zero)};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis < bend_.axes) {
        bend_.is_driven ? driven(phi, axis, all) : one_axis(phi, axis, all);
      } else {
        for (auto* P : {&all.P0, &all.P1, &all.P2, &all.P3, &all.P4, &all.P5}) (*P)[axis] = (*P)[0];
      }
    }
    return all;
  }

  [[nodiscard]] bool is_driven() const noexcept { return bend_.is_driven; }

  Three<V> w, q;

 private:
  static V gathered(const T* column, const std::size_t* at) noexcept {
    alignas(64) T lanes[V::size];
    for (std::size_t k = 0; k < V::size; ++k) lanes[k] = column[at[k]];
    return load_lanes<V>(lanes);
  }

  void make_series() noexcept {
    for (std::size_t axis = 0; axis < bend_.axes; ++axis) {
      V before(T(0));
      V d(T(1));
      for (std::size_t k = 0; k < bend_.degree; ++k) {
        series_[axis][k] = d * V(bend_.inverse_factorials[k]);
        const V next = V(T(0)) - multiply_add<arithmetic>(q[axis], d, w[axis] * before);
        before = d;
        d = next;
      }
    }
  }

  struct Sum {
    V value, slope;
  };
  [[nodiscard]] Sum sum_at(V part, std::size_t axis) const noexcept {
    const V* const series = series_[axis];
    Sum sum{series[bend_.degree - 1], V(T(0))};
    for (std::size_t k = bend_.degree - 1; k-- > 0;) {
      sum.slope = multiply_add<arithmetic>(sum.slope, part, sum.value);
      sum.value = multiply_add<arithmetic>(sum.value, part, series[k]);
    }
    return sum;
  }

  void one_axis(V phi, std::size_t axis, Responses<V>& all) const noexcept {
    const V one(T(1));
    const V part = V(bend_.scale) * phi;
    const Sum sum = sum_at(part, axis);
    V P2 = (part * part) * sum.value;
    V P1 = part * multiply_add<arithmetic>(part, sum.slope, sum.value + sum.value);
    V P0 = one - multiply_add<arithmetic>(q[axis], P1, w[axis] * P2);
    for (int n = 0; n < bend_.halvings; ++n) double_lower(axis, P0, P1, P2);
    all.P0[axis] = P0;
    all.P1[axis] = P1;
    all.P2[axis] = P2;
  }

  void double_lower(std::size_t axis, V& P0, V& P1, V& P2) const noexcept {
    const V one(T(1));
    const V A = subtract_product<arithmetic>(one, w[axis], P2);
    const V P1_before = P1;
    P2 = multiply_add<arithmetic>(P2, one + A, P1 * P1);
    P1 = P1 * (A + P0);
    P0 = subtract_product<arithmetic>(P0 * P0, w[axis], P1_before * P1_before);
  }

  void driven(V phi, std::size_t axis, Responses<V>& all) const noexcept {
    const V one(T(1));
    const V half(T(0.5));
    const V sixth(T(1) / T(6));
    V a = V(bend_.scale) * phi;
    const Sum sum = sum_at(a, axis);
    const V square = a * a;
    V P5 = ((square * square) * a) * sum.value;
    V P4 = (square * square) * multiply_add<arithmetic>(a, sum.slope, V(T(5)) * sum.value);
    const auto below = [&](V power, V P, V P_above) { return power - multiply_add<arithmetic>(q[axis], P, w[axis] * P_above); };
    V P3 = below((sixth * square) * a, P4, P5);
    V P2 = below(half * square, P3, P4);
    V P1 = below(a, P2, P3);
    V P0 = below(one, P1, P2);
    for (int n = 0; n < bend_.halvings; ++n) {
      const V B = one + subtract_product<arithmetic>(one, w[axis], P2);
      const V u = P1 + a;
      const V square_half = half * (a * a);
      const V cube_sixth = sixth * ((a * a) * a);
      P5 = multiply_add<arithmetic>(
          P5, B, multiply_add<arithmetic>(P4, u, multiply_add<arithmetic>(P3, square_half, P2 * cube_sixth)));
      P4 = multiply_add<arithmetic>(P4, B, multiply_add<arithmetic>(P3, u, P2 * square_half));
      P3 = multiply_add<arithmetic>(P3, B, P2 * u);
      double_lower(axis, P0, P1, P2);
      a = a + a;
    }
    all.P0[axis] = P0;
    all.P1[axis] = P1;
    all.P2[axis] = P2;
    all.P3[axis] = P3;
    all.P4[axis] = P4;
    all.P5[axis] = P5;
  }

  const Bend<T>& bend_;
  V series_[3][most_bend_terms];
};

}  // namespace
}  // namespace dvdx
