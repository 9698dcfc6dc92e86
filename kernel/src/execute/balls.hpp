// Balls of a sub-step: their centers go to where skins and anchors are, then each particle is kept in or out of its own.
#pragma once

#include <algorithm>
#include <cstddef>

#include "compile/balls.hpp"
#include "compile/joined_motion.hpp"
#include "execute/driven_skin.hpp"
#include "execute/tasks.hpp"
#include "execute/workspace.hpp"

namespace dvdx {

template <class T>
class BallStep {
 public:
  BallStep(const JoinedMotion<T>& motion, JoinedWorkspace<T>& workspace, const WorkColumns<T>& work,
           const BallKernels<T>& kernels, const ParallelFor& parallel) noexcept
      : m_(motion),
        ws_(workspace),
        work_(work),
        lists_(motion.joints().balls->lists()),
        kernels_(kernels),
        parallel_(parallel) {}

  // Before the first sub-step of a call: poses and anchors are where they are at that time.
  void prepare(const Clock& at) const noexcept { prepare(at, lists_.size()); }

  // What the caller drives begins this step's way; poses are those at its start.
  void set_out(const Clock& clock, double step) const noexcept {
    for (std::size_t k = 0; k < ws_.skins.size(); ++k) {
      if (!ws_.skins[k].has_way()) continue;
      ws_.skins[k].begin(clock, step, [&](std::size_t i) { return undriven(k, i); });
    }
  }

  // At the end of a sub-step, when poses and anchors have got there.
  void keep(const Clock& at) const noexcept {
    if (m_.joints().substep() == 0) return;
    for_each_part(at, lists_.size(), [&](const BallList<T>& list, const BallTerms<T>& terms, std::size_t from, std::size_t to) {
      kernels_.keep(terms, list.bound, work_, from, to);
    });
    prepare(at, lists_.size() - 1);  // later lists may have moved what earlier ones hold
  }

 private:
  static constexpr std::size_t per_task = 2048;  // a fixed number, so that nothing depends on threads

  void prepare(const Clock& at, std::size_t lists) const noexcept {
    const auto prepared = [&](const BallList<T>& /*list*/, const BallTerms<T>& terms, std::size_t from, std::size_t to) {
      kernels_.prepare(terms, work_, from, to);
    };
    for_each_part(at, lists, prepared);
  }

  // List by list, as two may have a particle in common.
  template <class Use>
  void for_each_part(const Clock& at, std::size_t lists, const Use& use) const noexcept {
    for (std::size_t n = 0; n < lists; ++n) {
      const BallList<T>& list = lists_[n];
      BallTerms<T> terms = ws_.balls[n];
      terms.element = list.element.data();
      terms.r = list.r;
      terms.per_step = static_cast<T>(1 / m_.joints().substep());
      for_each_task(parallel_, tasks_of(list.size(), per_task), [&](std::size_t task) {
        const std::size_t from = task * per_task;
        const std::size_t to = std::min(list.size(), from + per_task);
        move(list, terms, at, from, std::min(list.count, to));
        use(list, terms, from, to);
      });
    }
  }

  void move(const BallList<T>& list, const BallTerms<T>& terms, const Clock& at, std::size_t from,
            std::size_t to) const noexcept {
    if (!list.skin) return follow_anchors(list, terms, from, to);
    const DrivenSkin& driven = ws_.skins[*list.skin];
    if (driven.is_driven()) {
      const double part = driven.part(at);
      move_to(list, terms, from, to, [&](std::size_t i) { return driven.at(i, part); });
    } else {
      move_to(list, terms, from, to, [&](std::size_t i) { return undriven(*list.skin, i); });
    }
  }

  void follow_anchors(const BallList<T>& list, const BallTerms<T>& terms, std::size_t from, std::size_t to) const noexcept {
    for (std::size_t s = from; s < to; ++s) {
      const std::size_t i = list.center[s];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        terms.c[axis][s] = work_.x[axis][i];
        terms.u[axis][s] = work_.v[axis][i];
      }
    }
  }

  template <class PointAt>
  void move_to(const BallList<T>& list, const BallTerms<T>& terms, std::size_t from, std::size_t to,
               const PointAt& point_at) const noexcept {
    const Vec3& origin = m_.origin();
    for (std::size_t s = from; s < to; ++s) {
      const SkinPoint point = point_at(list.center[s]);
      const double behind = list.is_backstop() ? list.behind[s] : 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        terms.c[axis][s] = static_cast<T>((point.x[axis] - behind * point.n[axis]) - origin[axis]);
        terms.u[axis][s] = static_cast<T>(point.u[axis] - behind * point.n_rate[axis]);
      }
    }
  }

  [[nodiscard]] SkinPoint undriven(std::size_t skin, std::size_t i) const noexcept {
    const SkinStart& start = m_.skins()[skin];
    SkinPoint point{.x = start.points[i]};
    if (!start.normals.empty()) point.n = start.normals[i];
    if (!start.motion) return point;
    const MovedPose& pose = ws_.poses[*start.motion];
    point.u = pose.velocity_of(point.x);
    point.x = pose.place(point.x);
    if (start.normals.empty()) return point;
    point.n = turned(pose.turn, point.n);
    point.n_rate = cross(pose.angular_velocity, point.n);
    return point;
  }

  const JoinedMotion<T>& m_;
  JoinedWorkspace<T>& ws_;
  const WorkColumns<T>& work_;  // as the pulses have left them
  const std::vector<BallList<T>>& lists_;
  const BallKernels<T>& kernels_;
  const ParallelFor& parallel_;
};

}  // namespace dvdx
