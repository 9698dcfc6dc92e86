// Names by which people look for what is here under another one: docs/names.md has more of them.
#pragma once

#include "dvdx/network.hpp"
#include "dvdx/scene.hpp"
#include "dvdx/turnover.hpp"

namespace dvdx {

using Gravity = Constant;       // .acceleration = {0, -9.81, 0}
using Pins = Kinematic;         // particles that are driven
using MaxDistance = Skin;       // how far a particle may be from its skinned place
using Tether = Tethers;         // how far from what it hangs on
using Collider = Contact;       // whatever particles meet
using StretchLimit = Distance;  // with Bound::at_most
using KillPlane = Boundary;     // where particles that come and go are removed

}  // namespace dvdx
