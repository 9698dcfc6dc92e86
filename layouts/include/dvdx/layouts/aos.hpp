// Array of structures: the caller's own particle struct, whatever else it holds.
#pragma once

#include <cstddef>
#include <span>
#include <type_traits>

#include "dvdx/layouts/state.hpp"

namespace dvdx {

// A view of one scalar field of an array of n structs: first is the field in the first struct.
template <class T>
Column<T> field(T* first, std::size_t struct_bytes, std::size_t n) noexcept {
  return {first, static_cast<std::ptrdiff_t>(struct_bytes), 1, n};
}

// A view of n structs that hold position and velocity as three consecutive T each, at any place within them. Other bytes of the
// structs are never read or written: other threads may use them meanwhile.
template <class T>
State<T> aos(T* first_position, T* first_velocity, std::size_t struct_bytes, std::size_t n) noexcept {
  State<T> state{.x = {}, .v = {}, .count = n, .clock = {}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    state.x[axis] = field(first_position + axis, struct_bytes, n);
    state.v[axis] = field(first_velocity + axis, struct_bytes, n);
  }
  return state;
}

// The number type of a vector of three: T[3], a type with value_type (std::array, glm::vec3, Eigen::Vector3f), or a struct that
// begins with x.
template <class Vector>
struct NumberOf {
  using Type = decltype(Vector::x);
};
template <class T>
struct NumberOf<T[3]> {
  using Type = T;
};
template <class Vector>
requires std::is_floating_point_v<typename Vector::value_type>
struct NumberOf<Vector> {
  using Type = typename Vector::value_type;
};

// A view of the caller's own structs, for example
//   struct Particle { glm::vec3 position; float age; glm::vec3 velocity; };
//   std::vector<Particle> particles(n);
//   auto state = dvdx::aos(particles, &Particle::position, &Particle::velocity);
// Both fields must be vectors of exactly three floats or three doubles.
template <class Particle, class Position, class Velocity>
auto aos(std::span<std::type_identity_t<Particle>> particles, Position Particle::*position,
         Velocity Particle::*velocity) noexcept {
  using T = typename NumberOf<Position>::Type;
  static_assert(std::is_same_v<T, typename NumberOf<Velocity>::Type>, "position and velocity are of one scalar type");
  static_assert(std::is_same_v<T, float> || std::is_same_v<T, double>, "position and velocity are of float or of double");
  static_assert(sizeof(Position) == 3 * sizeof(T) && sizeof(Velocity) == 3 * sizeof(T), "a vector is three numbers");
  if (particles.empty()) return State<T>{};
  Particle& first = particles.front();
  return aos(reinterpret_cast<T*>(&(first.*position)), reinterpret_cast<T*>(&(first.*velocity)), sizeof(Particle),
             particles.size());
}

}  // namespace dvdx
