// Responses within a step, scalar: written by hand beside bend.inl.hpp, the same letters in the same order of operations.
#pragma once

#include <array>
#include <cstddef>

#include "flow/terms.hpp"
#include "simd/particle.hpp"

namespace dvdx::reference {

template <class T>
struct Responses {
  std::array<T, 3> P0{}, P1{}, P2{};
  std::array<T, 3> P3{}, P4{}, P5{};  // where forces depend on time
};

template <class T>
struct Drive {
  std::array<T, 3> D1{}, D2{}, D3{};
};

template <Arithmetic arithmetic, class T>
class Bending {
 public:
  Bending(const Bend<T>& bend, std::size_t i) noexcept : bend_(bend) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      w[axis] = bend.w_each[axis] != nullptr ? bend.w_each[axis][i] : bend.w[axis];
      q[axis] = bend.q_each[axis] != nullptr ? bend.q_each[axis][i] : bend.q[axis];
    }
    for (std::size_t axis = 0; axis < bend.axes; ++axis) {
      T before = 0;
      T d = 1;
      for (std::size_t k = 0; k < bend.degree; ++k) {
        series_[axis][k] = d * bend.inverse_factorials[k];
        const T next = 0 - multiply_add<arithmetic>(q[axis], d, w[axis] * before);
        before = d;
        d = next;
      }
    }
  }

  [[nodiscard]] Responses<T> operator()(T phi) const noexcept {
    Responses<T> all;
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

  std::array<T, 3> w{}, q{};

 private:
  struct Sum {
    T value, slope;
  };
  [[nodiscard]] Sum sum_at(T part, std::size_t axis) const noexcept {
    const auto& series = series_[axis];
    Sum sum{series[bend_.degree - 1], 0};
    for (std::size_t k = bend_.degree - 1; k-- > 0;) {
      sum.slope = multiply_add<arithmetic>(sum.slope, part, sum.value);
      sum.value = multiply_add<arithmetic>(sum.value, part, series[k]);
    }
    return sum;
  }

  void one_axis(T phi, std::size_t axis, Responses<T>& all) const noexcept {
    const T part = bend_.scale * phi;
    const Sum sum = sum_at(part, axis);
    T P2 = (part * part) * sum.value;
    T P1 = part * multiply_add<arithmetic>(part, sum.slope, sum.value + sum.value);
    T P0 = 1 - multiply_add<arithmetic>(q[axis], P1, w[axis] * P2);
    for (int n = 0; n < bend_.halvings; ++n) double_lower(axis, P0, P1, P2);
    all.P0[axis] = P0;
    all.P1[axis] = P1;
    all.P2[axis] = P2;
  }

  void double_lower(std::size_t axis, T& P0, T& P1, T& P2) const noexcept {
    const T A = subtract_product<arithmetic>(T(1), w[axis], P2);
    const T P1_before = P1;
    P2 = multiply_add<arithmetic>(P2, 1 + A, P1 * P1);
    P1 = P1 * (A + P0);
    P0 = subtract_product<arithmetic>(P0 * P0, w[axis], P1_before * P1_before);
  }

  void driven(T phi, std::size_t axis, Responses<T>& all) const noexcept {
    const T half = T(0.5);
    const T sixth = T(1) / T(6);
    T a = bend_.scale * phi;
    const Sum sum = sum_at(a, axis);
    const T square = a * a;
    T P5 = ((square * square) * a) * sum.value;
    T P4 = (square * square) * multiply_add<arithmetic>(a, sum.slope, 5 * sum.value);
    const auto below = [&](T power, T P, T P_above) { return power - multiply_add<arithmetic>(q[axis], P, w[axis] * P_above); };
    T P3 = below((sixth * square) * a, P4, P5);
    T P2 = below(half * square, P3, P4);
    T P1 = below(a, P2, P3);
    T P0 = below(T(1), P1, P2);
    for (int n = 0; n < bend_.halvings; ++n) {
      const T B = 1 + subtract_product<arithmetic>(T(1), w[axis], P2);
      const T u = P1 + a;
      const T square_half = half * (a * a);
      const T cube_sixth = sixth * ((a * a) * a);
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
  std::array<std::array<T, most_bend_terms>, 3> series_{};
};

}  // namespace dvdx::reference
