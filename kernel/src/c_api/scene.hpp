// The handle of a scene.
#pragma once

#include <string>
#include <vector>

#include "dvdx/dvdx.h"
#include "dvdx/scene.hpp"

struct dvdx_scene {
  dvdx::Scene scene;
};

namespace dvdx::c_api {

Scalars scalars(const dvdx_scalars& from, const std::string& field);
Wind wind_of(const dvdx_wind& from);
// Throws Error if its modulus is negative, or if a triangle names a particle that has no place.
struct BentSheet {
  std::vector<Triangle> triangles;
  std::vector<Vec3> flat;
};
BentSheet bent_sheet_of(const dvdx_bending& from);

}  // namespace dvdx::c_api
