// Pose and velocity of a motion at any time of the scene.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "dvdx/layouts/state.hpp"
#include "dvdx/scene.hpp"
#include "math/moved_pose.hpp"

namespace dvdx {

// The most that a surface may turn in one flow, rad. A surface that turns by theta sees the path bend by theta^3 away from the
// parabola that the pass uses.
inline constexpr double most_turn = 0.5;

// A motion whose orientations and rates are computed once from its keys.
class PoseTrack {
 public:
  explicit PoseTrack(const Motion& motion);

  [[nodiscard]] const Vec3& center() const noexcept { return center_; }
  // At a key, the velocity is the one after the key.
  [[nodiscard]] MovedPose at(const Clock& clock) const noexcept;
  // Returns the pose at `end`, with the velocities that lead there from `start`.
  [[nodiscard]] MovedPose at_end_of(const Clock& start, const Clock& end) const noexcept;
  // Returns the first key that would have to be reached at an infinite speed.
  [[nodiscard]] std::optional<std::size_t> first_unreachable_key() const noexcept;
  // The greatest angular velocity between any two keys, rad/s.
  [[nodiscard]] double fastest_turn() const noexcept;

 private:
  struct Part {
    double start = 0;  // s
    Vec3 translation{};
    Quaternion turn{};
    Arrival arrival = Arrival::moving;
    Vec3 velocity{}, angular_velocity{};  // up to the next part
  };
  [[nodiscard]] static double passed_since(const Part& part, const Clock& clock) noexcept;

  Vec3 center_;
  std::vector<Part> parts_;
};

}  // namespace dvdx
