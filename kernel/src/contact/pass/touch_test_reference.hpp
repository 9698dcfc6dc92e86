// Whether a particle may touch a surface within the step, scalar: written by hand beside touch_test.inl.hpp.
#pragma once

#include <cstddef>
#include <limits>

#include "contact/pass/moving_reference.hpp"
#include "contact/pass/push_out_reference.hpp"
#include "contact/surfaces/shape_reference.hpp"
#include "flow/terms.hpp"

namespace dvdx::reference {

template <Arithmetic arithmetic, class T>
bool may_touch_plane(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle) noexcept {
  if (dot<arithmetic>(surface.n, p.x1) < surface.d) return true;
  return surface.finds_dips && dot<arithmetic>(surface.n, middle) < surface.d;
}

template <Arithmetic arithmetic, class T>
bool may_touch_sphere(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle) noexcept {
  const Vector<T> r0 = difference(p.x0, surface.center);
  const Vector<T> r1 = difference(p.x1, surface.center);
  const Vector<T> rm = difference(middle, surface.center);
  const T square = surface.radius * surface.radius;
  if (surface.side < 0) {
    if (dot<arithmetic>(r1, r1) > square) return true;
    return surface.finds_dips && dot<arithmetic>(rm, rm) > square;
  }
  const T reach = square * dot<arithmetic>(r0, r0);
  const auto is_near = [&](const Vector<T>& r) {
    const T along = dot<arithmetic>(r0, r);
    return along <= 0 || along * along <= reach;
  };
  return is_near(r1) || (surface.finds_dips && is_near(rm));
}

template <Arithmetic arithmetic, class T>
bool may_touch(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle) noexcept {
  switch (surface.shape) {
    case Shape::plane:
      return may_touch_plane<arithmetic>(surface, p, middle);
    case Shape::sphere:
      return may_touch_sphere<arithmetic>(surface, p, middle);
    case Shape::capsule:
    case Shape::box:
    case Shape::convex:
    case Shape::mesh:
      break;
  }
  return may_touch_solid<arithmetic>(surface, p, middle);
}

// t: the remaining time of the step, s; corner: the time after which the tangents at both ends of the path meet, s.
template <Arithmetic arithmetic, class T>
bool may_touch_moving(const Surface<T>& surface, const Particle<T>& p, const Vector<T>& middle, T t, T corner) noexcept {
  if (surface.movement == Movement::rest) {
    return may_touch<arithmetic>(surface, p, middle) && (!surface.is_searched || overlaps(surface, p, middle));
  }
  const Particle<T> seen = seen_from<arithmetic>(surface, p, t);
  Vector<T> between;
  for (std::size_t k = 0; k < 3; ++k) between[k] = multiply_add<arithmetic>(corner, seen.v0[k], seen.x0[k]);
  return may_touch<arithmetic>(surface, seen, between) && (!surface.is_searched || overlaps(surface, seen, between));
}

template <Arithmetic arithmetic, class T>
bool may_touch(const Terms<T>& terms, const Particle<T>& p) noexcept {
  const T corner = terms.h * terms.bend.corner;
  Vector<T> middle;
  for (std::size_t k = 0; k < 3; ++k) middle[k] = multiply_add<arithmetic>(corner, p.v0[k], p.x0[k]);
  for (std::size_t j = 0; j < terms.surface_count; ++j) {
    const Surface<T>& surface = terms.surfaces[j];
    if (may_touch_moving<arithmetic>(surface, p, middle, terms.h, corner)) return true;
    if (pushes_out(surface) && start_on<arithmetic>(surface, p.x0, terms.h).is_inside) return true;
  }
  return false;
}

}  // namespace dvdx::reference
