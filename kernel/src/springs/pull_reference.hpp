// One spring, scalar: the twin of pull.inl.hpp.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

#include "simd/particle.hpp"
#include "springs/network.hpp"

namespace dvdx::reference {

template <class T>
using Vector = std::array<T, 3>;

template <class T>
Vector<T> at(const std::array<T*, 3>& columns, std::size_t i) noexcept {
  return {columns[0][i], columns[1][i], columns[2][i]};
}
template <class T>
Vector<T> at(const std::array<const T*, 3>& columns, std::size_t i) noexcept {
  return {columns[0][i], columns[1][i], columns[2][i]};
}
template <class T>
Vector<T> minus(const Vector<T>& a, const Vector<T>& b) noexcept {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class T>
Vector<T> plus(const Vector<T>& a, const Vector<T>& b) noexcept {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <class T>
Vector<T> times(T s, const Vector<T>& a) noexcept {
  return {s * a[0], s * a[1], s * a[2]};
}

template <Arithmetic arithmetic, class T>
T inner(const Vector<T>& a, const Vector<T>& b) noexcept {
  return multiply_add<arithmetic>(a[2], b[2], multiply_add<arithmetic>(a[1], b[1], a[0] * b[0]));
}

template <Arithmetic arithmetic, class T>
T inverse_root(T x) noexcept {
  using Bits = typename InverseRoot<T>::Bits;
  const T half = T(0.5) * x;
  T y = std::bit_cast<T>(InverseRoot<T>::magic - (std::bit_cast<Bits>(x) >> 1));
  for (int step = 1; step < InverseRoot<T>::steps; ++step) {
    y = y * subtract_product<arithmetic>(T(1.5), half * y, y);
  }
  return multiply_add<arithmetic>(y, subtract_product<arithmetic>(T(0.5), half * y, y), y);
}

template <class T>
struct Length {
  bool is_sound;
  T square, inverse;
};

template <Arithmetic arithmetic, class T>
Length<T> length(const Vector<T>& d) noexcept {
  const T r2 = inner<arithmetic>(d, d);
  if (!(r2 > least_square<T> && r2 < most_square<T>)) return {false, T(1), T(1)};
  return {true, r2, inverse_root<arithmetic>(r2)};
}

template <Arithmetic arithmetic, class T>
Vector<T> pull(const Vector<T>& d, T k, T kl) noexcept {
  const auto [is_sound, r2, y] = length<arithmetic>(d);
  if (!is_sound) return {};
  return times(subtract_product<arithmetic>(k, kl, y), d);
}

template <Arithmetic arithmetic, class T>
Vector<T> damped_pull(const Vector<T>& d, const Vector<T>& u, T k, T kl, T c) noexcept {
  const auto [is_sound, r2, y] = length<arithmetic>(d);
  const T du = inner<arithmetic>(d, u);
  if (!is_sound || !(std::abs(du) < most_square<T>)) return {};
  const T s = multiply_add<arithmetic>(c * du, y * y, subtract_product<arithmetic>(k, kl, y));
  return times(s, d);
}

template <Arithmetic arithmetic, class T>
Vector<T> damping_pull(const Vector<T>& d, const Vector<T>& u, T c) noexcept {
  const T r2 = inner<arithmetic>(d, d);
  const T du = inner<arithmetic>(d, u);
  if (!(r2 > least_square<T> && r2 < most_square<T>) || !(std::abs(du) < most_square<T>)) return {};
  return times(c * du / r2, d);
}

template <class T>
void leave_acceleration(const WorkColumns<T>& work, std::size_t i, const Vector<T>& F) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) work.a0[axis][i] = work.w[i] * F[axis];
}

template <Arithmetic arithmetic, class T>
void leave_damped(const WorkColumns<T>& work, const DampingPass<T>& pass, std::size_t i, const Vector<T>& F) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const T of = pass.of[axis][i];
    const T y = work.w[i] * F[axis];
    T v = multiply_add<arithmetic>(pass.s, of, work.v[axis][i]);
    if (pass.y[0] != nullptr) {
      pass.y[axis][i] = y;
    } else {
      v = multiply_add<arithmetic>(pass.t, y, v);
    }
    work.v[axis][i] = v;
  }
}

}  // namespace dvdx::reference
