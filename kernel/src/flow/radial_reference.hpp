// The radial pass, scalar: written by hand beside radial.inl.hpp, the same letters in the same order of operations.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "flow/radial.hpp"
#include "simd/particle.hpp"

namespace dvdx::reference {

template <class T>
T value_of(T all, const T* each, std::size_t i) noexcept {
  return each != nullptr ? each[i] : all;
}

template <class T>
struct Axis {
  std::array<T, 3> n{};  // 0 where there is no direction
  T length = 0;
};

template <Arithmetic arithmetic, class T>
Axis<T> axis_of(const std::array<T, 3>& r) noexcept {
  Axis<T> axis;
  const T xy = multiply_add<arithmetic>(r[1], r[1], r[0] * r[0]);
  axis.length = std::sqrt(multiply_add<arithmetic>(r[2], r[2], xy));
  const T inverse = axis.length > 0 ? 1 / axis.length : T(0);
  for (std::size_t k = 0; k < 3; ++k) axis.n[k] = inverse * r[k];
  return axis;
}

template <Arithmetic arithmetic, class T>
T project(const std::array<T, 3>& n, const std::array<T, 3>& v) noexcept {
  return multiply_add<arithmetic>(n[2], v[2], multiply_add<arithmetic>(n[1], v[1], n[0] * v[0]));
}

template <Arithmetic arithmetic, class T>
Axis<T> axis_now(const RadialTerms<T>& spring, const Particle<T>& p, std::size_t i) noexcept {
  std::array<T, 3> r;
  for (std::size_t k = 0; k < 3; ++k) r[k] = p.x1[k] - value_of(spring.anchor[k], spring.anchor_each[k], i);
  return axis_of<arithmetic>(r);
}

template <Arithmetic arithmetic, class T>
void damp(const RadialTerms<T>& spring, Particle<T>& p, std::size_t i) noexcept {
  const T E = value_of(spring.E, spring.E_each, i);
  if (spring.E_each == nullptr && E == 1) return;
  const Axis<T> axis = axis_now<arithmetic>(spring, p, i);
  const T change = (1 - E) * project<arithmetic>(axis.n, p.v1);
  for (std::size_t k = 0; k < 3; ++k) p.v1[k] = subtract_product<arithmetic>(p.v1[k], change, axis.n[k]);
}

template <Arithmetic arithmetic, class T>
void radial_kick(const Terms<T>& terms, Particle<T>& p, std::size_t i) noexcept {
  for (std::size_t s = 0; s < terms.kicks; ++s) damp<arithmetic>(terms.radial[s], p, i);
  for (std::size_t s = 0; s < terms.kicks; ++s) {
    const RadialTerms<T>& spring = terms.radial[s];
    const Axis<T> axis = axis_now<arithmetic>(spring, p, i);
    const T e = axis.length - value_of(spring.rest_length, spring.rest_length_each, i);
    const T change = value_of(spring.kappa, spring.kappa_each, i) * e;
    for (std::size_t k = 0; k < 3; ++k) p.v1[k] = subtract_product<arithmetic>(p.v1[k], change, axis.n[k]);
  }
  for (std::size_t s = terms.kicks; s > 0; --s) damp<arithmetic>(terms.radial[s - 1], p, i);
}

template <Arithmetic arithmetic, class T>
void radial_contribution(const Terms<T>& terms, Particle<T>& p, std::size_t i) noexcept {
  const T half = terms.h * T(0.5);
  for (std::size_t s = terms.kicks; s < terms.radial_count; ++s) {
    const RadialTerms<T>& spring = terms.radial[s];
    std::array<T, 3> r;
    for (std::size_t k = 0; k < 3; ++k) {
      r[k] = multiply_add<arithmetic>(half, p.v0[k], p.x0[k] - value_of(spring.anchor[k], spring.anchor_each[k], i));
    }
    const Axis<T> axis = axis_of<arithmetic>(r);
    const T u = project<arithmetic>(axis.n, p.v0);
    const T e = subtract_product<arithmetic>(axis.length - value_of(spring.rest_length, spring.rest_length_each, i), half, u);
    const T Ae = value_of(spring.A, spring.A_each, i) * e;
    const T Ce = value_of(spring.C, spring.C_each, i) * e;
    const T pulse_v = multiply_add<arithmetic>(value_of(spring.B, spring.B_each, i), u, Ae);
    const T pulse_x = multiply_add<arithmetic>(value_of(spring.D, spring.D_each, i), u, Ce);
    for (std::size_t k = 0; k < 3; ++k) {
      p.v1[k] = subtract_product<arithmetic>(p.v1[k], pulse_v, axis.n[k]);
      p.x1[k] = subtract_product<arithmetic>(p.x1[k], pulse_x, axis.n[k]);
    }
  }
}

}  // namespace dvdx::reference
