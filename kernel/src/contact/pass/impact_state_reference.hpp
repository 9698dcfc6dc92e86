// Distances from surfaces, and the state of a path between impacts, scalar: written by hand beside impact_state.inl.hpp.
#pragma once

#include <array>
#include <cstddef>

#include "contact/pass/moving_reference.hpp"
#include "contact/pass/recording_reference.hpp"
#include "contact/surfaces/shape_reference.hpp"
#include "flow/bend_reference.hpp"
#include "flow/terms.hpp"

namespace dvdx::reference {

template <Arithmetic arithmetic, class T>
Touch<T> touch_sphere(const Surface<T>& surface, const Vector<T>& x) noexcept {
  const Vector<T> r = difference(x, surface.center);
  const T length = std::sqrt(dot<arithmetic>(r, r));
  const T s = surface.side * (length - surface.radius);
  if (length > 0) {
    const T scale = surface.side / length;
    return {{scale * r[0], scale * r[1], scale * r[2]}, s};
  }
  return {{surface.side * r[0], surface.side, surface.side * r[2]}, s};
}

template <Arithmetic arithmetic, class T>
Touch<T> touch(const Surface<T>& surface, const Vector<T>& x) noexcept {
  switch (surface.shape) {
    case Shape::plane:
      return {surface.n, dot<arithmetic>(surface.n, x) - surface.d};
    case Shape::sphere:
      return touch_sphere<arithmetic>(surface, x);
    case Shape::capsule:
    case Shape::box:
    case Shape::convex:
    case Shape::mesh:
      break;
  }
  return touch_solid<arithmetic>(surface, x);
}

template <class T>
struct Path {
  Vector<T> u{}, a{};
};

template <class T>
Path<T> path(const Surface<T>& surface, const Particle<T>& p, T t) noexcept {
  const Vector<T> chord = difference(p.x1, p.x0);
  if (goes_straight(surface)) return {chord, {}};
  Path<T> path;
  for (std::size_t k = 0; k < 3; ++k) {
    path.u[k] = t * p.v0[k];
    path.a[k] = chord[k] - path.u[k];
  }
  return path;
}

// The surfaces that hold a particle for the rest of its step, and the changes that these made to its end.
template <class T>
struct Supports {
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  std::size_t a = none, b = none, c = none;
  Vector<T> dx{}, dv{};

  [[nodiscard]] bool has(std::size_t j) const noexcept { return a == j || b == j || c == j; }
};

// The last impact of a particle of a network on a surface without restitution: its index, the normal velocity that it took, and
// the velocity before.
template <class T>
struct Pressed {
  std::size_t by = Supports<T>::none;
  T removed = 0;
  Vector<T> v{};
};

// A particle that leaves surfaces inside which it starts: the place and the time (before the end) of the start.
template <class T>
struct Leaving {
  Vector<T> x0{};
  T t = 0;
};

// The state of a particle in a step. t: the remaining time of the step, s.
template <Arithmetic arithmetic, PathForm form, class T>
struct ImpactState {
  T direction, t;
  std::size_t last;  // index of the surface hit last, or the count of surfaces
  Supports<T> supports{};
  Pressed<T> pressed{};
  const Bending<arithmetic, T>* bending = nullptr;
  T h = 0, left = 1;
  Responses<T> end{};
  Drive<T> drive{};
  Recording<T>* recording = nullptr;    // null: nothing is logged
  const Leaving<T>* leaving = nullptr;  // null: it leaves no surface inside which it starts
};

template <Arithmetic arithmetic, class T>
Vector<T> driven(const Drive<T>& drive, const Vector<T>& first, const Vector<T>& second, const Vector<T>& third) noexcept {
  Vector<T> sum;
  for (std::size_t k = 0; k < 3; ++k) {
    sum[k] = multiply_add<arithmetic>(drive.D3[k], third[k],
                                      multiply_add<arithmetic>(drive.D2[k], second[k], drive.D1[k] * first[k]));
  }
  return sum;
}

template <class T>
Vector<T> sum_of(const Vector<T>& a, const Vector<T>& b) noexcept {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

template <Arithmetic arithmetic, class T>
struct FlowPath {
  Vector<T> u{}, F{};
  const Drive<T>* drive = nullptr;

  [[nodiscard]] Vector<T> way(const Responses<T>& P) const noexcept {
    Vector<T> way;
    for (std::size_t k = 0; k < 3; ++k) way[k] = multiply_add<arithmetic>(F[k], P.P2[k], u[k] * P.P1[k]);
    return drive != nullptr ? sum_of(way, driven<arithmetic>(*drive, P.P3, P.P4, P.P5)) : way;
  }
  [[nodiscard]] Vector<T> rate(const Responses<T>& P) const noexcept {
    Vector<T> rate;
    for (std::size_t k = 0; k < 3; ++k) rate[k] = multiply_add<arithmetic>(F[k], P.P1[k], u[k] * P.P0[k]);
    return drive != nullptr ? sum_of(rate, driven<arithmetic>(*drive, P.P2, P.P3, P.P4)) : rate;
  }
};

template <class T>
T inverse(T P) noexcept {
  return P != 0 ? 1 / P : T(0);
}

template <Arithmetic arithmetic, class T>
FlowPath<arithmetic, T> flow_path(const Particle<T>& p, const ImpactState<arithmetic, PathForm::flow, T>& state) noexcept {
  FlowPath<arithmetic, T> path;
  const auto& P = state.end;
  Vector<T> way = difference(p.x1, p.x0);
  if (state.bending->is_driven()) {
    path.drive = &state.drive;
    way = difference(way, driven<arithmetic>(state.drive, P.P3, P.P4, P.P5));
  }
  for (std::size_t k = 0; k < 3; ++k) {
    path.u[k] = state.h * p.v0[k];
    path.F[k] = subtract_product<arithmetic>(way[k], path.u[k], P.P1[k]) * inverse(P.P2[k]);
  }
  return path;
}

template <Arithmetic arithmetic, class T>
Vector<T> along(const Vector<T>& start, const Path<T>& path, T f) noexcept {
  Vector<T> x;
  for (std::size_t k = 0; k < 3; ++k) {
    x[k] = multiply_add<arithmetic>(f, multiply_add<arithmetic>(f, path.a[k], path.u[k]), start[k]);
  }
  return x;
}

}  // namespace dvdx::reference
