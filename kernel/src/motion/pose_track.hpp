// Pose and velocity of a motion, at any time of the scene.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "dvdx/layouts/state.hpp"
#include "dvdx/scene.hpp"
#include "math/moved_pose.hpp"

namespace dvdx {

// rad: a surface that turns by theta in a flow sees a path that bends by theta^3 where the pass has a parabola, so by this at
// most.
inline constexpr double most_turn = 0.5;

// A motion, its keys' orientations and rates made once.
class PoseTrack {
 public:
  explicit PoseTrack(const Motion& motion);

  [[nodiscard]] const Vec3& center() const noexcept { return center_; }
  // At a key the velocity is that after it.
  [[nodiscard]] MovedPose at(const Clock& clock) const noexcept;
  // At `end`, with the velocities that lead there from `start`.
  [[nodiscard]] MovedPose at_end_of(const Clock& start, const Clock& end) const noexcept;
  // The first key that is not reached at a finite speed.
  [[nodiscard]] std::optional<std::size_t> first_without_end() const noexcept;
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
