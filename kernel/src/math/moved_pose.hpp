// The place and the velocity that a rigid motion gives to points that follow it, at one time.
#pragma once

#include "math/rotation.hpp"

namespace dvdx {

// A point p is at center + translation + turn (p - center), and moves by velocity + angular_velocity x turn (p - center).
struct MovedPose {
  Vec3 center{}, translation{};
  Quaternion turn{};
  Vec3 velocity{}, angular_velocity{};  // m/s, rad/s

  [[nodiscard]] Vec3 arm(const Vec3& p) const noexcept { return turned(turn, difference(p, center)); }
  [[nodiscard]] Vec3 place(const Vec3& p) const noexcept {
    const Vec3 r = arm(p);
    return {(p[0] + translation[0]) + (r[0] - (p[0] - center[0])), (p[1] + translation[1]) + (r[1] - (p[1] - center[1])),
            (p[2] + translation[2]) + (r[2] - (p[2] - center[2]))};
  }
  [[nodiscard]] Vec3 velocity_of(const Vec3& p) const noexcept {
    const Vec3 c = cross(angular_velocity, arm(p));
    return {velocity[0] + c[0], velocity[1] + c[1], velocity[2] + c[2]};
  }
};

}  // namespace dvdx
