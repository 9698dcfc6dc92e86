// Bodies with a signed distance: a capsule, a box, a convex body, a mesh, as the contact pass reads them, and where its
// formulas come from.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

// Distance. s(x) is positive outside, n(x) its gradient; y = A (x - c) in the axes of the body, about its center.
//   capsule the hull of two spheres is the union of balls about p(l) = l w, |l| <= L, of radius r(l) = r + b l, so that s =
//          min_l |y - p(l)| - r(l). With eta = w.y and rho = |y - eta w| the least is at l = eta + rho b/sqrt(1-b^2), taken
//          to -L..L: s = |y - p| - r(l), n = (y - p)/|y - p|. Where one sphere holds the other, L = 0.
//   box    q_k = |y_k| - h_k; outside s = |max(q, 0)|, n = max(q, 0)/s with the signs of y; inside s = max_k q_k, and n is
//          that face's normal. The root of a single square is exact, so that a face is a plane.
//   convex  s = max_k (n_k.y - d_k), n = n_k: beside an edge less than the distance, and 0 where that is.
//   thick  what a thickness t rounds has s - t: capsule and box. The planes of a convex body are moved by it instead.
// Bound.   Each is convex. So it lies behind the plane through the point nearest to x0, n0.(x - x0) <= -s0, and what stays
//          in front of that plane touches nothing. Nor does a trajectory whose box does not overlap the box about the ball
//          that holds the body.
// Impact.  Tangent planes: from a point of the path at f, outside, to where the path meets the plane n.(x - x_f) = -s, the
//          root of s + d g + c g^2, d = n.(u + 2 f a), c = n.a, in the form of surface.hpp. The body is behind that plane,
//          so no step passes an impact, and a path that does not meet one of the planes misses. A face of a box takes one
//          step, a round body about as many as Newton's; at a graze a step halves the rest of the way. On a path that
//          springs, drag or forces of time bend, that is the first guess for Newton's steps with a bracket.
// Mesh.    phi is given at the nodes of a grid about the body, less the thickness, and is linear along each axis between them;
//          g its slope, n = g/|g|. s is the way to phi = 0 along n, so that x - s n is on the surface: phi/|g|, and within
//          two cells of it Newton's steps from there; 0 where phi is within rounding. Beyond the grid s is the distance from
//          the box about the body, which is less than that from the body, and no smaller than the grid's margin.
//          A mesh is not convex, and has no tangent planes. No slope of phi is steeper than L, so nothing is nearer than
//          phi/L: the path is followed by steps of that length, taken at its greatest speed, and of a quarter of a cell at
//          least. Where phi has turned negative the last step is halved, and the chord is followed to its zero. A start
//          inside is on its way out first.
// Source:  E. G. Gilbert, D. W. Johnson and S. S. Keerthi, 1988 (supporting planes); the distances are elementary.

namespace dvdx {

template <class T>
struct Solid {
  std::array<std::array<T, 3>, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // A; a capsule's first is w
  std::array<T, 3> half_extents{};                                          // box: h; mesh: of the box about it, m
  T thickness = 0;                                                          // box, m
  T half_length = 0, middle_radius = 0;                                     // capsule: L, r, m
  T slope = 0, lean = 0;                                                    // capsule: b, b/sqrt(1 - b^2)
  const std::array<T, 4>* planes = nullptr;                                 // convex: n_k, d_k
  std::size_t plane_count = 0;
  std::array<double, 3> home{};                 // convex, mesh: the center in the scene, m
  const T* values = nullptr;                    // mesh: phi at the nodes, x fastest, m
  std::array<std::uint32_t, 3> nodes{};         // mesh: along each axis
  std::array<T, 3> low{};                       // mesh: the first node, from the center, m
  T cell = 0, inverse_cell = 0, steepness = 1;  // mesh: of the grid; L
};

// Tangent planes to an impact, and Newton's steps along a bent path.
inline constexpr int approach_steps = 16;
inline constexpr int solid_newton_steps = 12;

// For a mesh: Newton's steps along a normal; steps along a path, of which those to a crossing take a few, and all only what
// goes along the surface from end to end of the largest grid; halvings of the last.
inline constexpr int normal_steps = 6;
inline constexpr int march_steps = 4096;
inline constexpr int march_halvings = 12;

}  // namespace dvdx
