// Long double vectors for motions that contacts interrupt.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "dvdx/values.hpp"

namespace dvdx::tool::impacts {

using Real = long double;

struct Vector {
  std::array<Real, 3> components{};

  Real& operator[](std::size_t axis) { return components[axis]; }
  Real operator[](std::size_t axis) const { return components[axis]; }

  Vector& operator+=(const Vector& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) components[axis] += other[axis];
    return *this;
  }
  Vector& operator-=(const Vector& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) components[axis] -= other[axis];
    return *this;
  }
  Vector& operator*=(Real factor) {
    for (auto& component : components) component *= factor;
    return *this;
  }
};

inline Vector operator+(Vector a, const Vector& b) { return a += b; }
inline Vector operator-(Vector a, const Vector& b) { return a -= b; }
inline Vector operator*(Real factor, Vector a) { return a *= factor; }

inline Real dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Real length(const Vector& a) { return std::hypot(a[0], a[1], a[2]); }
inline Vector unit(const Vector& a) { return (1 / length(a)) * a; }

inline Vector cross(const Vector& a, const Vector& b) {
  return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}

// The product for each axis.
inline Vector scaled(const Vector& by, const Vector& a) { return {{by[0] * a[0], by[1] * a[1], by[2] * a[2]}}; }

inline Vector vector_of(const Vec3& v) { return {{v[0], v[1], v[2]}}; }

}  // namespace dvdx::tool::impacts
