// One spring in each lane. The scalar twin: pull_reference.hpp.
#pragma once

#include "simd/estimates.inl.hpp"
#include "simd/lanes.hpp"
#include "simd/three.inl.hpp"
#include "springs/network.hpp"

namespace dvdx {
namespace {

template <Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline V inverse_root(V x) noexcept {
  using T = Scalar<V>;
  if constexpr (arithmetic == Arithmetic::fast && terms_of_estimate<T> != 0) return inverse_root_by_estimate(x);
  const V half = V(T(0.5)) * x;
  V y = magic_guess<V>(x, InverseRoot<T>::magic);
  for (int step = 1; step < InverseRoot<T>::steps; ++step) {
    y = y * subtract_product<arithmetic>(V(T(1.5)), half * y, y);
  }
  return multiply_add<arithmetic>(y, subtract_product<arithmetic>(V(T(0.5)), half * y, y), y);
}

template <class V>
struct Length {
  Mask<V> is_sound;
  V square, inverse;  // r^2 and 1/r; anything where the spring is not sound
};

template <Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline Length<V> length(const Three<V>& d) noexcept {
  using T = Scalar<V>;
  const V r2 = dot<arithmetic>(d, d);
  return {(r2 > V(least_square<T>)) & (r2 < V(most_square<T>)), r2, inverse_root<arithmetic>(r2)};
}

template <class V>
[[gnu::always_inline]] inline Three<V> product_where(const Mask<V>& where, V s, const Three<V>& d) noexcept {
  return {{product_where<V>(where, s, d[0]), product_where<V>(where, s, d[1]), product_where<V>(where, s, d[2])}};
}

// The force on the end that d leads away from.
template <Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline Three<V> pull(const Three<V>& d, V k, V kl) noexcept {
  const auto [is_sound, r2, y] = length<arithmetic>(d);
  return product_where(is_sound, subtract_product<arithmetic>(k, kl, y), d);
}

template <Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline Three<V> damped_pull(const Three<V>& d, const Three<V>& u, V k, V kl, V c) noexcept {
  const auto [is_long, r2, y] = length<arithmetic>(d);
  const V du = dot<arithmetic>(d, u);
  const Mask<V> is_sound = is_long & (magnitude(du) < V(most_square<Scalar<V>>));
  const V s = multiply_add<arithmetic>(c * du, y * y, subtract_product<arithmetic>(k, kl, y));
  return product_where(is_sound, s, d);
}

// The force of the damping alone.
template <Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline Three<V> damping_pull(const Three<V>& d, const Three<V>& u, V c) noexcept {
  using T = Scalar<V>;
  const V r2 = dot<arithmetic>(d, d);
  const V du = dot<arithmetic>(d, u);
  const Mask<V> is_sound = (r2 > V(least_square<T>)) & (r2 < V(most_square<T>)) & (magnitude(du) < V(most_square<T>));
  return product_where(is_sound, quotient(c * du, r2), d);
}

template <class V>
[[gnu::always_inline]] inline Three<V> load_three(const std::array<Scalar<V>*, 3>& columns, std::size_t i) noexcept {
  return {{load_lanes<V>(columns[0] + i), load_lanes<V>(columns[1] + i), load_lanes<V>(columns[2] + i)}};
}
template <class V>
[[gnu::always_inline]] inline Three<V> load_three(const std::array<const Scalar<V>*, 3>& columns, std::size_t i) noexcept {
  return {{load_lanes<V>(columns[0] + i), load_lanes<V>(columns[1] + i), load_lanes<V>(columns[2] + i)}};
}
template <class V>
[[gnu::always_inline]] inline void store_three(const std::array<Scalar<V>*, 3>& columns, std::size_t i,
                                               const Three<V>& value) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) store_lanes(columns[axis] + i, value[axis]);
}

// Stores the result of a pass for the particles from i on. F: the sum of their springs' forces.
template <class V>
[[gnu::always_inline]] inline void leave_acceleration(const WorkColumns<Scalar<V>>& work, std::size_t i,
                                                      const Three<V>& F) noexcept {
  store_three<V>(work.a0, i, load_lanes<V>(work.w + i) * F);
}
template <Arithmetic arithmetic, class V>
[[gnu::always_inline]] inline void leave_damped(const WorkColumns<Scalar<V>>& work, const DampingPass<Scalar<V>>& pass,
                                                std::size_t i, const Three<V>& F) noexcept {
  const Three<V> of = load_three<V>(pass.of, i);
  const Three<V> y = load_lanes<V>(work.w + i) * F;
  Three<V> v = multiply_add<arithmetic>(V(pass.s), of, load_three<V>(work.v, i));
  if (pass.y[0] != nullptr) {
    store_three<V>(pass.y, i, y);
  } else {
    v = multiply_add<arithmetic>(V(pass.t), y, v);
  }
  store_three<V>(work.v, i, v);
}

}  // namespace
}  // namespace dvdx
