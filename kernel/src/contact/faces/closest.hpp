// Where a triangle comes nearest to a convex core.
#pragma once

#include <array>
#include <span>

#include "math/vec3.hpp"

// Equation  The least |w| of the differences w = a - b, a on the triangle, b in the core: the point of least norm of the convex
//           hull of the differences of their corners. A core is the hull of balls; of a ball (p, s) the farthest point along n
//           is p + s n.
// Solution  P. Wolfe's: the point of least norm of the hull of up to four corners (the corral), to which the corner is added
//           that is farthest towards the origin, and from which those go that the point of least norm of their plane lies
//           beyond. The corner along x bounds what is left: |w| >= x.w / |x| for every w of the hull.
// Limits    Where the hull holds the origin the core meets the triangle, and there is no direction.
// Source    P. Wolfe, Finding the nearest point in a polytope, 1976; E. G. Gilbert, D. W. Johnson and S. S. Keerthi, 1988.

namespace dvdx {

// A part of a core: of none the radius is the core's own, which stands apart.
struct CoreBall {
  Vec3 at{};          // m
  double radius = 0;  // m, >= 0
};

enum class Meeting { apart, far, pierced };  // far: farther than was asked for; pierced: the core meets the triangle

struct Closest {
  Meeting how = Meeting::far;
  double distance = 0;             // m; of `apart`, as are those below
  Vec3 n{};                        // of unit length, from the core to the triangle
  std::array<double, 3> weight{};  // of the point on the triangle: not negative, their sum is 1
};

[[nodiscard]] Closest closest(const std::array<Vec3, 3>& triangle, std::span<const CoreBall> core, double far) noexcept;

}  // namespace dvdx
