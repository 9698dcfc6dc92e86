// Motions and kinematic particles that the caller drives by requests "be there at the end of the next step". Each state has its
// own, in its workspace.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "math/rigid_motion.hpp"
#include "motion/pose_track.hpp"

namespace dvdx {

// The step during which a driven motion or group of particles travels to its target.
struct DrivenStep {
  Clock begin{};
  double duration = 1;  // s

  // Returns the part of the step that has passed, 0..1: exactly 1 at the end, which a sum of sub-steps may miss by rounding.
  [[nodiscard]] double part_passed(const Clock& at) const noexcept {
    const double part = ((at.seconds - begin.seconds) + (at.carry - begin.carry)) / duration;
    if (part > 1 - 1e-6) return 1;
    return part > 0 ? part : 0;
  }

  // Passes each number to an archive, which reads or writes it. The other pass() functions below do the same.
  template <class Archive>
  void pass(Archive& archive) {
    for (double* const number : {&begin.seconds, &begin.carry, &duration}) archive(*number);
  }
};

// The pose that a motion was asked to reach.
struct PoseTarget {
  Vec3 translation{};
  Quaternion turn{};
};

class DrivenMotion {
 public:
  void ask(const Vec3& translation, const Vec3& rotation) noexcept { asked_ = PoseTarget{translation, quaternion(rotation)}; }
  void jump(const Vec3& translation, const Vec3& rotation) noexcept {
    jumped_ = PoseTarget{translation, quaternion(rotation)};
    asked_.reset();
  }

  // Moves the current pose and all targets by `by`. If the motion follows its keys, their poses move along.
  void carry(const RigidMotion& by, const PoseTrack& track) noexcept {
    for (std::optional<PoseTarget>* const target : {&asked_, &jumped_}) {
      if (!*target) continue;
      const MovedPose pose =
          moved(by, {.center = track.center(), .translation = (*target)->translation, .turn = (*target)->turn});
      *target = PoseTarget{pose.translation, pose.turn};
    }
    if (!to_) {
      carried_ = carried_ ? by * *carried_ : by;
      return;
    }
    from_ = moved(by, from_);
    to_ = moved(by, *to_);
  }

  // Puts a motion that has jumped at rest at its new pose. Runs before each call of step().
  void arrive(const PoseTrack& track, const Clock& clock) noexcept {
    if (!jumped_) return;
    MovedPose pose = at(track, clock);
    pose.translation = jumped_->translation;
    pose.turn = jumped_->turn;
    rest_at(pose);
    jumped_.reset();
  }

  // Begins a step of `duration` s. It leads to the pose asked for; without one, a motion that was driven rests where it is.
  void begin(const PoseTrack& track, const Clock& clock, double duration) noexcept {
    if (!asked_) {
      if (to_) rest_at(*to_);
      return;
    }
    const PoseTarget target = *std::exchange(asked_, std::nullopt);
    from_ = at(track, clock);
    for (std::size_t k = 0; k < 3; ++k) from_.velocity[k] = (target.translation[k] - from_.translation[k]) / duration;
    from_.angular_velocity = scaled(rotation_vector(target.turn * conjugate(from_.turn)), 1 / duration);
    to_ = from_;
    to_->translation = target.translation;
    to_->turn = target.turn;
    step_ = {clock, duration};
  }

  [[nodiscard]] MovedPose at(const PoseTrack& track, const Clock& clock) const noexcept {
    if (!to_) return by_keys(track.at(clock));
    const double part = step_.part_passed(clock);
    if (part == 1) return *to_;
    MovedPose pose = from_;
    const double passed = part * step_.duration;
    for (std::size_t k = 0; k < 3; ++k) pose.translation[k] = from_.translation[k] + passed * from_.velocity[k];
    pose.turn = quaternion(scaled(from_.angular_velocity, passed)) * from_.turn;
    return pose;
  }
  // Returns the pose at `end`, with the velocities that lead there from `start`.
  [[nodiscard]] MovedPose at_end_of(const PoseTrack& track, const Clock& start, const Clock& end) const noexcept {
    return to_ ? at(track, end) : by_keys(track.at_end_of(start, end));
  }

  template <class Archive>
  void pass(Archive& archive) {
    const auto pass_vector = [&](Vec3& v) {
      for (double& number : v) archive(number);
    };
    const auto pass_pose = [&](MovedPose& pose) {
      for (Vec3* const v : {&pose.center, &pose.translation, &pose.turn.v, &pose.velocity, &pose.angular_velocity})
        pass_vector(*v);
      archive(pose.turn.w);
    };
    for (std::optional<PoseTarget>* const place : {&asked_, &jumped_}) {
      pass_there(archive, *place, [&](PoseTarget& target) {
        pass_vector(target.translation);
        pass_vector(target.turn.v);
        archive(target.turn.w);
      });
    }
    pass_there(archive, carried_, [&](RigidMotion& by) {
      pass_vector(by.translation);
      pass_vector(by.turn.v);
      archive(by.turn.w);
    });
    pass_there(archive, to_, [&](MovedPose& to) {
      pass_pose(to);
      pass_pose(from_);
      step_.pass(archive);
    });
  }

 private:
  // Passes whether the value is there and, if so, the value.
  template <class Archive, class Value, class Pass>
  static void pass_there(Archive& archive, std::optional<Value>& value, const Pass& pass) {
    bool is_there = value.has_value();
    archive(is_there);
    if (is_there && !value) value.emplace();
    if (!is_there) value.reset();
    if (value) pass(*value);
  }

  [[nodiscard]] MovedPose by_keys(const MovedPose& pose) const noexcept { return carried_ ? moved(*carried_, pose) : pose; }

  void rest_at(MovedPose pose) noexcept {
    pose.velocity = pose.angular_velocity = {};
    from_ = pose;
    to_ = pose;
  }

  std::optional<PoseTarget> asked_, jumped_;
  std::optional<RigidMotion> carried_;  // moves the pose that the keys give
  MovedPose from_;
  std::optional<MovedPose> to_;  // none: the motion follows its keys
  DrivenStep step_;
};

// The particles of one group of Scene::kinematic, each with its own path. Places are in m, in world coordinates.
class DrivenPlaces {
 public:
  explicit DrivenPlaces(std::size_t particles = 0) : particles_(particles) {}

  [[nodiscard]] std::size_t particles() const noexcept { return particles_; }
  [[nodiscard]] bool is_driven() const noexcept { return is_driven_; }

  // Allocates at the first call. If that fails, it changes nothing.
  void ask(std::span<const Vec3> places) {
    if (paths_.empty()) paths_.resize(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) paths_[i].asked = places[i];
    is_asked_ = true;
  }
  // Puts the particles at rest at `places`. It allocates as ask() does.
  void jump(std::span<const Vec3> places) {
    if (paths_.empty()) paths_.resize(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) paths_[i] = {.from = places[i], .to = places[i]};
    is_driven_ = true;
    is_asked_ = false;
  }

  void carry(const RigidMotion& by) noexcept {
    for (Path& path : paths_) {
      for (Vec3* const place : {&path.from, &path.to, &path.asked}) *place = by.place(*place);
      path.velocity = by.direction(path.velocity);
    }
  }

  [[nodiscard]] bool has_path() const noexcept { return is_asked_ || is_driven_; }

  // Begin a step of a group that has a path: first each particle, from `undriven` unless it was driven before, then the group.
  void begin(std::size_t i, const Vec3& undriven, double duration) noexcept {
    Path& path = paths_[i];
    path.from = is_driven_ ? path.to : undriven;
    path.to = is_asked_ ? path.asked : path.from;
    path.velocity = scaled(difference(path.to, path.from), 1 / duration);
  }
  void begin(const Clock& clock, double duration) noexcept {
    is_driven_ = true;
    is_asked_ = false;
    step_ = {clock, duration};
  }

  [[nodiscard]] Vec3 place(std::size_t i, const Clock& clock) const noexcept {
    const Path& path = paths_[i];
    const double part = step_.part_passed(clock);
    if (part == 1) return path.to;
    Vec3 x = path.from;
    for (std::size_t k = 0; k < 3; ++k) x[k] += part * step_.duration * path.velocity[k];
    return x;
  }
  [[nodiscard]] const Vec3& velocity(std::size_t i) const noexcept { return paths_[i].velocity; }

  // has(n) returns whether the archive has n more numbers. It is asked before memory is allocated for them.
  template <class Archive, class Has>
  void pass(Archive& archive, const Has& has) {
    archive(is_asked_);
    archive(is_driven_);
    if (!has_path()) return;
    constexpr std::size_t numbers = sizeof(Path) / sizeof(double);
    if (paths_.empty() && has(numbers * particles_)) paths_.resize(particles_);
    for (Path& path : paths_) {
      for (Vec3* const v : {&path.from, &path.to, &path.asked, &path.velocity}) {
        for (double& number : *v) archive(number);
      }
    }
    step_.pass(archive);
  }

 private:
  struct Path {
    Vec3 from{}, to{}, asked{}, velocity{};
  };
  std::size_t particles_;
  std::vector<Path> paths_;
  bool is_asked_ = false, is_driven_ = false;
  DrivenStep step_;
};

}  // namespace dvdx
