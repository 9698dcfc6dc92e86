// The radial pass, wide. radial.hpp derives the formulas; the scalar twin is radial_reference.hpp.
#pragma once

#include <cstddef>

#include "flow/radial.hpp"
#include "simd/three.inl.hpp"
#include "simd/trajectory.inl.hpp"

namespace dvdx {
namespace {

template <class V>
V value_of(Scalar<V> all, const Scalar<V>* each, std::size_t i) noexcept {
  return each == nullptr ? V(all) : load_lanes<V>(each + i);
}

template <class V>
Three<V> from_anchor(const RadialTerms<Scalar<V>>& spring, const Three<V>& x, std::size_t i) noexcept {
  return {{x[0] - value_of<V>(spring.anchor[0], spring.anchor_each[0], i),
           x[1] - value_of<V>(spring.anchor[1], spring.anchor_each[1], i),
           x[2] - value_of<V>(spring.anchor[2], spring.anchor_each[2], i)}};
}

template <class V>
struct Axis {
  Three<V> n;
  V length;
};

template <class V, Arithmetic arithmetic>
Axis<V> axis_of(const Three<V>& r) noexcept {
  const V zero(Scalar<V>(0));
  const V one(Scalar<V>(1));
  const V length = square_root(dot<arithmetic>(r, r));
  const auto has_direction = length > zero;
  const V inverse = select<V>(has_direction, quotient<V>(one, select<V>(has_direction, length, one)), zero);
  return {inverse * r, length};
}

template <class V, Arithmetic arithmetic>
void damp(const RadialTerms<Scalar<V>>& spring, Trajectory<V>& m, std::size_t i) noexcept {
  if (spring.E_each == nullptr && spring.E == 1) return;
  const auto n = axis_of<V, arithmetic>(from_anchor(spring, m.x1, i)).n;
  const V loss = V(Scalar<V>(1)) - value_of<V>(spring.E, spring.E_each, i);
  m.v1 = subtract_product<arithmetic>(m.v1, loss * dot<arithmetic>(n, m.v1), n);
}

template <class V, Arithmetic arithmetic>
void kick(const RadialTerms<Scalar<V>>& spring, Trajectory<V>& m, std::size_t i) noexcept {
  const auto axis = axis_of<V, arithmetic>(from_anchor(spring, m.x1, i));
  const V kappa = value_of<V>(spring.kappa, spring.kappa_each, i);
  const V e = axis.length - value_of<V>(spring.rest_length, spring.rest_length_each, i);
  m.v1 = subtract_product<arithmetic>(m.v1, kappa * e, axis.n);
}

template <class V, Arithmetic arithmetic>
void radial_kick(const Terms<Scalar<V>>& terms, Trajectory<V>& m, std::size_t i) noexcept {
  for (std::size_t k = 0; k < terms.kicks; ++k) damp<V, arithmetic>(terms.radial[k], m, i);
  for (std::size_t k = 0; k < terms.kicks; ++k) kick<V, arithmetic>(terms.radial[k], m, i);
  for (std::size_t k = terms.kicks; k-- > 0;) damp<V, arithmetic>(terms.radial[k], m, i);
}

template <class V, Arithmetic arithmetic>
void contribute(const RadialTerms<Scalar<V>>& spring, V half, Trajectory<V>& m, std::size_t i) noexcept {
  const auto axis = axis_of<V, arithmetic>(multiply_add<arithmetic>(half, m.v0, from_anchor(spring, m.x0, i)));
  const V u = dot<arithmetic>(axis.n, m.v0);
  const V stretch = axis.length - value_of<V>(spring.rest_length, spring.rest_length_each, i);
  const V e = subtract_product<arithmetic>(stretch, half, u);
  const V A = value_of<V>(spring.A, spring.A_each, i);
  const V B = value_of<V>(spring.B, spring.B_each, i);
  const V C = value_of<V>(spring.C, spring.C_each, i);
  const V D = value_of<V>(spring.D, spring.D_each, i);
  m.v1 = subtract_product<arithmetic>(m.v1, multiply_add<arithmetic>(B, u, A * e), axis.n);
  m.x1 = subtract_product<arithmetic>(m.x1, multiply_add<arithmetic>(D, u, C * e), axis.n);
}

template <class V, Arithmetic arithmetic>
void radial_contribution(const Terms<Scalar<V>>& terms, Trajectory<V>& m, std::size_t i) noexcept {
  const V half(terms.h * Scalar<V>(0.5));
  for (std::size_t k = terms.kicks; k < terms.radial_count; ++k) contribute<V, arithmetic>(terms.radial[k], half, m, i);
}

}  // namespace
}  // namespace dvdx
