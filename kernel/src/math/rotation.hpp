// Rotations in double, from + - * / , sqrt and the sines of elementary.hpp: their bits are the same everywhere.
#pragma once

#include "math/elementary.hpp"
#include "math/vec3.hpp"

namespace dvdx {

// Has unit length: cos(angle/2), sin(angle/2) axis.
struct Quaternion {
  double w = 1;
  Vec3 v{};
};

// First b, then a.
[[nodiscard]] inline Quaternion operator*(const Quaternion& a, const Quaternion& b) noexcept {
  const Vec3 c = cross(a.v, b.v);
  Quaternion q{a.w * b.w - dot(a.v, b.v), {}};
  for (std::size_t k = 0; k < 3; ++k) q.v[k] = (a.w * b.v[k] + b.w * a.v[k]) + c[k];
  return q;
}

[[nodiscard]] inline Quaternion conjugate(const Quaternion& q) noexcept { return {q.w, scaled(q.v, -1)}; }

// The quaternion of a rotation vector: the axis times the angle, rad.
[[nodiscard]] inline Quaternion quaternion(const Vec3& rotation) noexcept {
  const double angle = length(rotation);
  if (angle == 0) return {};
  const auto [sine, cosine] = sincos(angle / 2);
  return {cosine, scaled(rotation, sine / angle)};
}

// x + 2 v x (w x + v x x): a point on the axis stays to the last bit.
[[nodiscard]] inline Vec3 turned(const Quaternion& q, const Vec3& x) noexcept {
  const Vec3 t = cross(q.v, x);
  const Vec3 u = cross(q.v, t);
  return {x[0] + 2 * (q.w * t[0] + u[0]), x[1] + 2 * (q.w * t[1] + u[1]), x[2] + 2 * (q.w * t[2] + u[2])};
}

// The angle in 0..pi/2 whose sine and cosine are s and c, s^2 + c^2 = 1 but for rounding. The first guess is right to 0.07 rad.
// Each round takes the error to its fifth power: d = tan(angle - t), angle = t + d - d^3/3 + ...
[[nodiscard]] inline double angle_of(double s, double c) noexcept {
  double t = s / (s + c) * half_pi[0];
  for (int round = 0; round < 3; ++round) {
    const auto [sine, cosine] = sincos(t);
    const double d = (s * cosine - c * sine) / (c * cosine + s * sine);
    t += d - d * d * d / 3;
  }
  return t;
}

// The rotation vector of q, the short way round.
[[nodiscard]] inline Vec3 rotation_vector(const Quaternion& q) noexcept {
  const double s = length(q.v);
  if (s == 0) return {};
  const double angle = 2 * angle_of(s, std::abs(q.w));
  return scaled(q.v, (q.w < 0 ? -angle : angle) / s);
}

}  // namespace dvdx
