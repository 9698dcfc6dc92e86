// The signed distance of a point from a surface, and the velocity of the surface there.
#pragma once

#include "contact/surfaces/surface.hpp"
#include "meet/meet.hpp"

namespace dvdx {

template <class T>
struct Off {
  Point<T> n{};    // out of the surface
  T distance = 0;  // m, from where flows keep a particle; negative inside
};

template <class T>
Off<T> off_surface(const Surface<T>& surface, const Point<T>& x) noexcept;
// m/s
template <class T>
Point<T> velocity_of(const Surface<T>& surface, const Point<T>& x) noexcept;

}  // namespace dvdx
