// Bodies with a signed distance (capsule, box, convex body, mesh) as the contact pass reads them, and the derivation of its
// formulas.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

// Distance. s(x) is positive outside, n(x) is its gradient, and y = A (x - c) is x in the axes of the body, about its center.
//   capsule The hull of two spheres is the union of balls about p(l) = l w, |l| <= L, of radius r(l) = r + b l, so
//          s = min_l |y - p(l)| - r(l). With eta = w.y and rho = |y - eta w| the minimum is at l = eta + rho b/sqrt(1-b^2),
//          clamped to -L..L: s = |y - p| - r(l), n = (y - p)/|y - p|. If one sphere contains the other, L = 0.
//   box    q_k = |y_k| - h_k. Outside, s = |max(q, 0)| and n = max(q, 0)/s with the signs of y. Inside, s = max_k q_k, and n is
//          the normal of that face. The root of a single square is exact, so a face is a plane.
//   convex s = max_k (n_k.y - d_k), n = n_k. Beside an edge s is less than the distance; both vanish at the same points.
//   thick  A thickness t rounds a capsule and a box: their distance is s - t. It moves the planes of a convex body outwards.
// Bound.   These bodies are convex. Each lies behind the plane through its point nearest to x0, n0.(x - x0) <= -s0, so a path
//          in front of that plane touches nothing. A trajectory touches nothing either if its box does not overlap the box
//          about the ball that contains the body.
// Impact.  By tangent planes. From a point x_f of the path outside the body, a step leads to where the path meets the plane
//          n.(x - x_f) = -s: the root of s + d g + c g^2, d = n.(u + 2 f a), c = n.a, in the form of surface.hpp. The body is
//          behind that plane, so no step passes an impact, and a path that misses one of the planes misses the body. A box's
//          face takes one step, a round body about as many as Newton's method; at a graze a step halves the remaining way. On a
//          path that springs, drag or forces of time bend, the result is the first guess for Newton's steps with a bracket.
// Mesh.    phi, the distance less the thickness, is given at the nodes of a grid about the body and is linear along each axis
//          between them; g is its slope, n = g/|g|. s is the way to phi = 0 along n, so x - s n is on the surface: phi/|g|,
//          within two cells refined by Newton's steps, and 0 where phi is within rounding. Beyond the grid s is the distance
//          from the box about the body: less than the distance from the body, and no smaller than the grid's margin.
//          A mesh is not convex and has no tangent planes. No slope of phi is steeper than L, so the surface is no nearer than
//          phi/L. The path is followed in steps of that length at its greatest speed, and of at least a quarter of a cell.
//          Where phi turns negative the last step is bisected, and the chord is followed to its zero. A path that starts inside
//          hits at once if it goes inwards; otherwise it must come out first.
// Source:  E. G. Gilbert, D. W. Johnson and S. S. Keerthi, 1988 (supporting planes); the distances are elementary.

namespace dvdx {

template <class T>
struct Solid {
  std::array<std::array<T, 3>, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // A; the first axis of a capsule is w
  std::array<T, 3> half_extents{};                                          // box: h; mesh: those of the box about it, m
  T thickness = 0;                                                          // box, m
  T half_length = 0, middle_radius = 0;                                     // capsule: L, r, m
  T slope = 0, lean = 0;                                                    // capsule: b, b/sqrt(1 - b^2)
  const std::array<T, 4>* planes = nullptr;                                 // convex: n_k, d_k
  std::size_t plane_count = 0;
  std::array<double, 3> home{};                 // convex, mesh: the center in the scene, m
  const T* values = nullptr;                    // mesh: phi at the nodes, x fastest, m
  std::array<std::uint32_t, 3> nodes{};         // mesh: number along each axis
  std::array<T, 3> low{};                       // mesh: the first node, relative to the center, m
  T cell = 0, inverse_cell = 0, steepness = 1;  // mesh: a cell of the grid, m, and its inverse; L
};

// The most tangent planes to an impact, and Newton's steps along a bent path.
inline constexpr int approach_steps = 16;
inline constexpr int solid_newton_steps = 12;

// For a mesh: Newton's steps along a normal, the most steps along a path, bisections of the last step. A crossing takes a few
// steps; only a path along the surface from end to end of the largest grid takes all.
inline constexpr int normal_steps = 6;
inline constexpr int march_steps = 4096;
inline constexpr int march_halvings = 12;

}  // namespace dvdx
