// Vectors of the scene, in double, from + - * / and sqrt alone: their bits are the same with every compiler and math library.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "dvdx/scene.hpp"

namespace dvdx {

[[nodiscard]] inline Vec3 sum(const Vec3& a, const Vec3& b) noexcept { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
[[nodiscard]] inline Vec3 difference(const Vec3& a, const Vec3& b) noexcept { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
[[nodiscard]] inline Vec3 scaled(const Vec3& a, double factor) noexcept {
  return {a[0] * factor, a[1] * factor, a[2] * factor};
}
[[nodiscard]] inline double dot(const Vec3& a, const Vec3& b) noexcept { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
[[nodiscard]] inline Vec3 cross(const Vec3& a, const Vec3& b) noexcept {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// Squares of very long or very short vectors over- or underflow. For these a power of two is taken out first, which rounds
// nothing: the result has the same bits at every scale.
[[nodiscard]] inline double length(const Vec3& a) noexcept {
  constexpr double large = 0x1p+510;
  constexpr double small = 0x1p-430;  // its square, and 2^-53 of that, are normal numbers
  const double largest = std::max({std::abs(a[0]), std::abs(a[1]), std::abs(a[2])});
  double scale = 1;
  if (largest > large) scale = 0x1p-600;
  if (largest < small) scale = 0x1p+600;
  const Vec3 w = scaled(a, scale);
  return std::sqrt(dot(w, w)) / scale;
}

[[nodiscard]] inline double distance(const Vec3& a, const Vec3& b) noexcept { return length(difference(b, a)); }

// For a vector that is not zero. It is first divided by its largest component, so that its length neither over- nor underflows.
[[nodiscard]] inline Vec3 unit(const Vec3& a) noexcept {
  const double largest = std::max({std::abs(a[0]), std::abs(a[1]), std::abs(a[2])});
  const Vec3 w{a[0] / largest, a[1] / largest, a[2] / largest};
  const double l = length(w);
  return {w[0] / l, w[1] / l, w[2] / l};
}

// Two unit vectors across a direction and each other. For an axis they are the other two axes, without rounding.
[[nodiscard]] inline std::array<Vec3, 2> across(const Vec3& direction) noexcept {
  const Vec3 t = unit(direction);
  std::size_t least = 0;
  for (std::size_t axis = 1; axis < 3; ++axis) {
    if (std::abs(t[axis]) < std::abs(t[least])) least = axis;
  }
  Vec3 other{};
  other[least] = 1;
  const Vec3 n1 = unit(cross(t, other));
  return {n1, cross(t, n1)};
}

}  // namespace dvdx
