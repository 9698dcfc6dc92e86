// Planes for one particle, and access to its state in a trial.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "hard_cases/trial.hpp"

namespace dvdx::tool::stability {

inline constexpr double gravity = 9.81;
inline constexpr double infinite = std::numeric_limits<double>::infinity();

inline double product(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double length(const Vec3& a) { return std::sqrt(product(a, a)); }
inline Vec3 scaled(const Vec3& a, double s) { return {s * a[0], s * a[1], s * a[2]}; }

template <class T>
Vec3 position(const Trial<T>& trial, std::size_t i = 0) {
  return {trial.x(0, i), trial.x(1, i), trial.x(2, i)};
}
template <class T>
Vec3 velocity(const Trial<T>& trial, std::size_t i = 0) {
  return {trial.v(0, i), trial.v(1, i), trial.v(2, i)};
}

inline Plane wall(const Vec3& normal, double offset, double restitution) {
  return {.normal = normal, .offset = offset, .restitution = restitution};
}
inline Plane ground(double restitution) { return wall({0, 1, 0}, 0, restitution); }

inline Scene scene_of(const std::vector<Plane>& planes, const Vec3& acceleration = {}) {
  Scene scene;
  if (acceleration != Vec3{}) scene.add(Constant{.acceleration = acceleration});
  for (const Plane& plane : planes) scene.add(Contact(plane));
  return scene;
}
inline Scene falling(const std::vector<Plane>& planes) { return scene_of(planes, {0, -gravity, 0}); }

}  // namespace dvdx::tool::stability
