// Planes and states for tests of the contact pass.
#pragma once

#include <cmath>

#include "dvdx/plan.hpp"
#include "kernel/passes/particles.hpp"

namespace dvdx::test::contacts {

inline constexpr Vec3 still{};
inline constexpr Vec3 gravity{0, -9.81, 0};

inline Plane plane(const Vec3& normal, double offset, double restitution) {
  Plane plane;
  plane.normal = normal;
  plane.offset = offset;
  plane.restitution = restitution;
  return plane;
}
inline Plane floor_with(double restitution) { return plane({0, 1, 0}, 0, restitution); }

template <class T>
State3<T> state(double x, double y, double z, double u, double v, double w) {
  return {{static_cast<T>(x), static_cast<T>(y), static_cast<T>(z)}, {static_cast<T>(u), static_cast<T>(v), static_cast<T>(w)}};
}

inline double product(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double length(const Vec3& a) { return std::sqrt(product(a, a)); }
inline Vec3 unit(const Vec3& a) { return {a[0] / length(a), a[1] / length(a), a[2] / length(a)}; }

}  // namespace dvdx::test::contacts
