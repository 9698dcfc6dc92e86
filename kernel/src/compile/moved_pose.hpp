// Where a motion has carried what follows it, and how fast, at any time of the scene.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "dvdx/layouts/state.hpp"
#include "dvdx/scene.hpp"
#include "math/rotation.hpp"

namespace dvdx {

// A point p is at  center + translation + turn (p - center), and moves by  velocity + angular_velocity x (its way from
// center + translation).
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

// A motion, its keys' orientations and rates made once.
class PoseTrack {
 public:
  explicit PoseTrack(const Motion& motion);

  // At a key the velocity is that after it.
  [[nodiscard]] MovedPose at(const Clock& clock) const noexcept;
  // The first key that is not reached at a finite speed.
  [[nodiscard]] std::optional<std::size_t> first_without_end() const noexcept;
  // The greatest angular velocity between any two keys, rad/s.
  [[nodiscard]] double fastest_turn() const noexcept;

 private:
  struct Part {
    double start = 0;  // s
    Vec3 translation{};
    Quaternion turn{};
    Vec3 velocity{}, angular_velocity{};  // up to the next part
  };
  Vec3 center_;
  std::vector<Part> parts_;
};

}  // namespace dvdx
