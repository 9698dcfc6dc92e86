// Three registers, one for each axis, and the operations of passes that couple the axes.
#pragma once

#include <array>
#include <cstddef>

#include "simd/lanes.hpp"

namespace dvdx {
namespace {

template <class V>
struct Three {
  V at[3];
  V& operator[](std::size_t axis) noexcept { return at[axis]; }
  const V& operator[](std::size_t axis) const noexcept { return at[axis]; }
};

template <class V>
Three<V> three(V all) noexcept {
  return {{all, all, all}};
}
template <class V>
Three<V> three(const std::array<Scalar<V>, 3>& axes) noexcept {
  return {{V(axes[0]), V(axes[1]), V(axes[2])}};
}

template <class V>
Three<V> operator+(const Three<V>& a, const Three<V>& b) noexcept {
  return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}};
}
template <class V>
Three<V> operator-(const Three<V>& a, const Three<V>& b) noexcept {
  return {{a[0] - b[0], a[1] - b[1], a[2] - b[2]}};
}
template <class V>
Three<V> operator*(V a, const Three<V>& b) noexcept {
  return {{a * b[0], a * b[1], a * b[2]}};
}

template <Arithmetic arithmetic, class V>
Three<V> multiply_add(V a, const Three<V>& b, const Three<V>& c) noexcept {
  return {{multiply_add<arithmetic>(a, b[0], c[0]), multiply_add<arithmetic>(a, b[1], c[1]),
           multiply_add<arithmetic>(a, b[2], c[2])}};
}
template <Arithmetic arithmetic, class V>
Three<V> subtract_product(const Three<V>& c, V a, const Three<V>& b) noexcept {
  return {{subtract_product<arithmetic>(c[0], a, b[0]), subtract_product<arithmetic>(c[1], a, b[1]),
           subtract_product<arithmetic>(c[2], a, b[2])}};
}
template <Arithmetic arithmetic, class V>
V dot(const Three<V>& a, const Three<V>& b) noexcept {
  return multiply_add<arithmetic>(a[2], b[2], multiply_add<arithmetic>(a[1], b[1], a[0] * b[0]));
}
template <class V>
V one_norm(const Three<V>& a) noexcept {
  return (magnitude(a[0]) + magnitude(a[1])) + magnitude(a[2]);
}
template <class V>
Mask<V> is_any_not_zero(const Three<V>& a) noexcept {
  const V zero(Scalar<V>(0));
  return differ(a[0], zero) | differ(a[1], zero) | differ(a[2], zero);
}
template <class V>
Three<V> select(const Mask<V>& where, const Three<V>& a, const Three<V>& b) noexcept {
  return {{select<V>(where, a[0], b[0]), select<V>(where, a[1], b[1]), select<V>(where, a[2], b[2])}};
}

}  // namespace
}  // namespace dvdx
