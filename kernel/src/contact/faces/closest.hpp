// The point of a triangle that is nearest to a convex core.
#pragma once

#include <array>
#include <span>

#include "math/vec3.hpp"

// Equation  Minimize |w| over the differences w = a - b, a on the triangle, b in the core: find the point of least norm in the
//           convex hull of the differences of their corners. A core is the hull of balls; the farthest point of a ball (p, s)
//           along n is p + s n.
// Solution  P. Wolfe's algorithm keeps the point x of least norm of the hull of up to four corners (the corral). Each round
//           adds the corner farthest towards the origin, and drops the corners beyond which the point of least norm of the
//           corral's plane lies. |w| >= x.w / |x| for every w of the hull, so the new corner, of least x.w, bounds |w|.
// Limits    If the hull contains the origin, the core meets the triangle, and there is no direction.
// Source    P. Wolfe, Finding the nearest point in a polytope, 1976; E. G. Gilbert, D. W. Johnson and S. S. Keerthi, 1988.

namespace dvdx {

// A ball of a core. FaceBody::radius is added to its radius.
struct CoreBall {
  Vec3 at{};          // m
  double radius = 0;  // m, >= 0
};

enum class Proximity { apart, far, pierced };  // far: beyond the given distance; pierced: the core meets the triangle

struct Closest {
  Proximity how = Proximity::far;
  double distance = 0;             // m; this and the following are set only for `apart`
  Vec3 n{};                        // of unit length, from the core to the triangle
  std::array<double, 3> weight{};  // of each corner in the point on the triangle: >= 0, their sum is 1
};

[[nodiscard]] Closest closest(const std::array<Vec3, 3>& triangle, std::span<const CoreBall> core, double far) noexcept;

}  // namespace dvdx
