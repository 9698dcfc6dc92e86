// Aliases by the usual names of other libraries: docs/names.md has more of them.
#pragma once

#include "dvdx/network.hpp"
#include "dvdx/scene.hpp"
#include "dvdx/turnover.hpp"

namespace dvdx {

using Gravity = Constant;       // .acceleration = {0, -9.81, 0}
using Pins = Kinematic;         // particles that are driven
using MaxDistance = Skin;       // limits the distance of a particle from its skinned place
using Tether = Tethers;         // limits the distance of a particle from its hold
using Collider = Contact;       // a body that particles meet
using StretchLimit = Distance;  // with Bound::at_most
using KillPlane = Boundary;     // where particles that come and go are removed

}  // namespace dvdx
