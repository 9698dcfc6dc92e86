// Bending resistance of a triangle mesh by the angles across its edges.
#pragma once

#include <span>

#include "dvdx/export.h"
#include "dvdx/network.hpp"
#include "dvdx/values.hpp"

namespace dvdx {

// Makes a sheet of these triangles resist bending, by springs of rest length 0 (Springs::zero_length) between the four corners
// of each two triangles that share an edge. A spring goes onto an existing entry of `pairs`, or onto a new one. A network whose
// edges are pairs gains one pair for each inner edge, between the corners across it. A flat sheet bears no bending force,
// however it is stretched or turned within its plane.
//   flat     m: the place of each particle in the unbent sheet. A sheet whose `flat` is not flat flattens.
//   modulus  N m >= 0: bending stiffness D. A sheet rolled to a radius R has the energy D/(2 R^2) per area. This holds for
//            equilateral triangles, whichever way they are rolled; right-angled ones that are all cut the same way have one to
//            three times D (docs/scene.md).
// Triangles without area, or with a particle that `flat` lacks, make zero_length not finite: compile() refuses it.
// Plan::set_bending() changes the bending while a plan runs.
// Source: M. Bergou, M. Wardetzky, D. Harmon, D. Zorin and E. Grinspun, A quadratic bending model for inextensible surfaces,
// 2006.
DVDX_EXPORT void add_bending(Springs& springs, std::span<const Triangle> triangles, std::span<const Vec3> flat, double modulus);

}  // namespace dvdx
