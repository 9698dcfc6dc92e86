// A rigid motion of the world, and its effect on places, directions and poses.
#pragma once

#include "math/moved_pose.hpp"

namespace dvdx {

// A point p goes to turn p + translation. Without a turn nothing but that sum is rounded.
struct RigidMotion {
  Quaternion turn{};
  Vec3 translation{};

  [[nodiscard]] Vec3 direction(const Vec3& v) const noexcept { return turned(turn, v); }
  [[nodiscard]] Vec3 place(const Vec3& p) const noexcept { return sum(direction(p), translation); }
  // The same motion, for places that are counted from an origin.
  [[nodiscard]] RigidMotion from(const Vec3& origin) const noexcept {
    return {turn, sum(translation, difference(direction(origin), origin))};
  }
};

// First b, then a.
[[nodiscard]] inline RigidMotion operator*(const RigidMotion& a, const RigidMotion& b) noexcept {
  return {a.turn * b.turn, a.place(b.translation)};
}

// The pose that carries a point first as `pose` does, and then as `by` does.
[[nodiscard]] inline MovedPose moved(const RigidMotion& by, MovedPose pose) noexcept {
  pose.translation = by.from(pose.center).place(pose.translation);
  pose.turn = by.turn * pose.turn;
  pose.velocity = by.direction(pose.velocity);
  pose.angular_velocity = by.direction(pose.angular_velocity);
  return pose;
}

}  // namespace dvdx
