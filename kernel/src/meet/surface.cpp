#include "meet/surface.hpp"

#include <cmath>

#include "contact/surfaces/shape_reference.hpp"

namespace dvdx {

template <class T>
Off<T> off_surface(const Surface<T>& surface, const Point<T>& x) noexcept {
  switch (surface.shape) {
    case Shape::plane:
      return {surface.n, inner(surface.n, x) - surface.d};
    case Shape::sphere: {
      const Point<T> r = minus(x, surface.center);
      const T length = std::sqrt(inner(r, r));
      if (!(length > 0)) return {surface.n, -surface.side * surface.radius};
      return {times(surface.side / length, r), surface.side * (length - surface.radius)};
    }
    case Shape::capsule:
    case Shape::box:
    case Shape::convex:
    case Shape::mesh:
      break;
  }
  const reference::Touch<T> touch = reference::touch_solid<Arithmetic::separate>(surface, x);
  return {touch.n, touch.s};
}

template <class T>
Point<T> velocity_of(const Surface<T>& surface, const Point<T>& x) noexcept {
  if (surface.movement == Movement::rest) return {};
  if (surface.movement == Movement::shifts) return surface.u;
  const Point<T> r = minus(x, surface.at);
  const Point<T>& o = surface.omega;
  return plus(surface.u, Point<T>{o[1] * r[2] - o[2] * r[1], o[2] * r[0] - o[0] * r[2], o[0] * r[1] - o[1] * r[0]});
}

template Off<float> off_surface<float>(const Surface<float>&, const Point<float>&) noexcept;
template Off<double> off_surface<double>(const Surface<double>&, const Point<double>&) noexcept;
template Point<float> velocity_of<float>(const Surface<float>&, const Point<float>&) noexcept;
template Point<double> velocity_of<double>(const Surface<double>&, const Point<double>&) noexcept;

}  // namespace dvdx
