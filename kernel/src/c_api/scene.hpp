// The handle of a scene.
#pragma once

#include "dvdx/dvdx.h"
#include "dvdx/scene.hpp"

struct dvdx_scene {
  dvdx::Scene scene;
};
