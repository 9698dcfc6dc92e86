// The handle of a scene.
#pragma once

#include <string>

#include "dvdx/dvdx.h"
#include "dvdx/scene.hpp"

struct dvdx_scene {
  dvdx::Scene scene;
};

namespace dvdx::c_api {

Scalars scalars(const dvdx_scalars& from, const std::string& field);
Wind wind_of(const dvdx_wind& from);

}  // namespace dvdx::c_api
