#include "motion/pose_track.hpp"

#include <algorithm>

namespace dvdx {

// Returns the time from the start of the part to `clock`, s.
double PoseTrack::passed_since(const Part& part, const Clock& clock) noexcept {
  return (clock.seconds - part.start) + clock.carry;
}

PoseTrack::PoseTrack(const Motion& motion) : center_(motion.center) {
  if (motion.keys.empty()) parts_.push_back({});
  for (const MotionKey& key : motion.keys) {
    const Quaternion turn = quaternion(key.rotation);
    if (!parts_.empty() && key.arrival == Arrival::moving) {
      Part& before = parts_.back();
      const double duration = key.time - before.start;
      before.velocity = scaled(difference(key.translation, before.translation), 1 / duration);
      before.angular_velocity = scaled(rotation_vector(turn * conjugate(before.turn)), 1 / duration);
    }
    parts_.push_back({.start = key.time, .translation = key.translation, .turn = turn, .arrival = key.arrival});
  }
}

MovedPose PoseTrack::at(const Clock& clock) const noexcept {
  const auto has_begun = [&](const Part& part) { return passed_since(part, clock) >= 0; };
  const auto next = std::partition_point(parts_.begin(), parts_.end(), has_begun);
  MovedPose pose{.center = center_};
  if (next == parts_.begin()) {
    pose.translation = next->translation;
    pose.turn = next->turn;
    return pose;
  }
  const Part& part = *(next - 1);
  const double passed = passed_since(part, clock);
  for (std::size_t k = 0; k < 3; ++k) pose.translation[k] = part.translation[k] + passed * part.velocity[k];
  pose.turn = quaternion(scaled(part.angular_velocity, passed)) * part.turn;
  pose.velocity = part.velocity;
  pose.angular_velocity = part.angular_velocity;
  return pose;
}

MovedPose PoseTrack::at_end_of(const Clock& start, const Clock& end) const noexcept {
  MovedPose pose = at(end);
  const double duration = (end.seconds - start.seconds) + (end.carry - start.carry);
  const MovedPose before = at(start);
  const Clock& earlier = duration < 0 ? end : start;
  const Clock& later = duration < 0 ? start : end;
  const bool has_jumped = std::any_of(parts_.begin(), parts_.end(), [&](const Part& part) {
    return part.arrival == Arrival::jump && passed_since(part, earlier) < 0 && passed_since(part, later) >= 0;
  });
  if (has_jumped) return pose;
  const bool is_any_key_between = std::any_of(parts_.begin(), parts_.end(), [&](const Part& part) {
    return passed_since(part, earlier) < 0 && passed_since(part, later) > 0;
  });
  if (!is_any_key_between) {
    if (duration < 0) return pose;
    pose.velocity = before.velocity;
    pose.angular_velocity = before.angular_velocity;
    return pose;
  }
  pose.velocity = scaled(difference(pose.translation, before.translation), 1 / duration);
  pose.angular_velocity = scaled(rotation_vector(pose.turn * conjugate(before.turn)), 1 / duration);
  return pose;
}

std::optional<std::size_t> PoseTrack::first_unreachable_key() const noexcept {
  const auto is_finite = [](const Vec3& v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); };
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    if (!is_finite(parts_[k].velocity) || !is_finite(parts_[k].angular_velocity)) return k + 1;
  }
  return std::nullopt;
}

double PoseTrack::fastest_turn() const noexcept {
  double most = 0;
  for (const Part& part : parts_) most = std::max(most, length(part.angular_velocity));
  return most;
}

}  // namespace dvdx
