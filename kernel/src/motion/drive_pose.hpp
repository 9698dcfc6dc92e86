// Checks and stores a caller's request that a motion be at a pose at the end of the next step, or jump to it.
#pragma once

#include <cstddef>
#include <vector>

#include "dvdx/plan.hpp"
#include "motion/driven.hpp"
#include "scene/checker.hpp"

namespace dvdx {

inline Expected<void> drive_pose(std::vector<DrivenMotion>& motions, std::size_t motion, const Pose& target, Arrival arrival) {
  if (motion >= motions.size()) return tl::unexpected(no_such("motions", motion, motions.size()));
  Checker check(std::nullopt);
  check.value("pose.translation", target.translation, Range::finite);
  check.value("pose.rotation", target.rotation, Range::finite);
  if (check.error) return tl::unexpected(*check.error);
  DrivenMotion& driven = motions[motion];
  arrival == Arrival::jump ? driven.jump(target.translation, target.rotation) : driven.ask(target.translation, target.rotation);
  return {};
}

}  // namespace dvdx
