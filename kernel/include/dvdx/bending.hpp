// Bend of a mesh of triangles by the angles across its edges.
#pragma once

#include <span>

#include "dvdx/export.h"
#include "dvdx/network.hpp"
#include "dvdx/values.hpp"

namespace dvdx {

// Makes a sheet of these triangles resist bending, by springs of no rest length (Springs::zero_length) between the four corners
// of each two triangles that share an edge: on `pairs` where there is one, else on a pair that is added. A network whose edges
// are pairs gains one spring for each inner edge, between the corners across it. A sheet that is flat, however it is stretched
// or turned within its plane, bears no force of it.
//   flat     m: the place of each particle where the sheet is not bent. Where it is not flat there either, it flattens.
//   modulus  N m >= 0: bending stiffness D, of which a sheet that is rolled to a radius R has the energy D/(2 R^2) an area.
//            So it is with triangles of equal sides, whichever way they are rolled; of right-angled ones that are cut all one
//            way with one time to three times D (docs/scene.md).
// Triangles of no area, and such as name a particle that has no place, make zero_length that are not finite: compile() refuses
// them. While a plan runs Plan::set_bending() changes it.
// Source: M. Bergou, M. Wardetzky, D. Harmon, D. Zorin and E. Grinspun, A quadratic bending model for inextensible surfaces,
// 2006.
DVDX_EXPORT void add_bending(Springs& springs, std::span<const Triangle> triangles, std::span<const Vec3> flat, double modulus);

}  // namespace dvdx
