// Vector operations for pictures.
#pragma once

#include <array>
#include <cmath>

#include "dvdx/values.hpp"

namespace dvdx::tool {

[[nodiscard]] inline Vec3 sum(const Vec3& a, const Vec3& b) noexcept { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
[[nodiscard]] inline Vec3 difference(const Vec3& a, const Vec3& b) noexcept { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
[[nodiscard]] inline Vec3 scaled(const Vec3& a, double by) noexcept { return {a[0] * by, a[1] * by, a[2] * by}; }
[[nodiscard]] inline double dot(const Vec3& a, const Vec3& b) noexcept { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
[[nodiscard]] inline Vec3 cross(const Vec3& a, const Vec3& b) noexcept {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
[[nodiscard]] inline double length(const Vec3& a) noexcept { return std::sqrt(dot(a, a)); }
// Returns zero if a is zero.
[[nodiscard]] inline Vec3 unit(const Vec3& a) noexcept {
  const double size = length(a);
  return size > 0 ? scaled(a, 1 / size) : Vec3{};
}
// Returns a unit vector orthogonal to a unit vector.
[[nodiscard]] inline Vec3 across(const Vec3& a) noexcept {
  return unit(cross(a, std::abs(a[0]) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
}
[[nodiscard]] inline bool is_finite(const Vec3& a) noexcept {
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

// Rotates p by a rotation vector: axis times angle, rad.
[[nodiscard]] inline Vec3 rotated(const Vec3& p, const Vec3& rotation) noexcept {
  const double angle = length(rotation);
  const Vec3 axis = unit(rotation);
  const double c = std::cos(angle);
  return sum(sum(scaled(p, c), scaled(cross(axis, p), std::sin(angle))), scaled(axis, dot(axis, p) * (1 - c)));
}

}  // namespace dvdx::tool
