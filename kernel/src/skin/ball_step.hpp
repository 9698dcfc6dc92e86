// The balls in a sub-step: their centers go to where skins and anchors are, then each particle is kept in or out of its ball.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "math/moved_pose.hpp"
#include "skin/balls.hpp"
#include "skin/driven_skin.hpp"
#include "springs/network.hpp"
#include "work/tasks.hpp"

namespace dvdx {

// A scene's balls and skins, and what moves them. h: s, the sub-step; origin: m, of the working columns.
template <class T>
struct BallsOfScene {
  const std::vector<BallList<T>>& lists;
  const std::vector<BallTerms<T>>& terms;  // c, u and n of each list
  const std::vector<SkinStart>& skins;
  std::vector<DrivenSkin>& driven;
  const std::vector<MovedPose>& poses;  // of each motion, at the end of the flow
  const Vec3& origin;
  double h;
};

template <class T>
class BallStep {
 public:
  BallStep(const BallsOfScene<T>& of, const WorkColumns<T>& work, const BallKernels<T>& kernels,
           const ParallelFor& parallel) noexcept
      : of_(of), work_(work), lists_(of.lists), kernels_(kernels), parallel_(parallel) {}

  // Called before the first sub-step of a call. Poses and anchors are where they are at that time.
  void prepare(const Clock& at) const noexcept {
    for (std::size_t k = 0; k < of_.driven.size(); ++k) of_.driven[k].arrive([&](std::size_t i) { return undriven(k, i); });
    for_each_part(lists_.size(), [&](const BallList<T>& list, const BallTerms<T>& terms, std::size_t from, std::size_t to) {
      move(list, terms, at, from, std::min(list.count, to));
      kernels_.prepare(terms, work_, from, to);
    });
  }

  // Begins this step's paths of the skins that the caller drives. Poses are those at its start.
  void begin_driven_paths(const Clock& clock, double step) const noexcept {
    for (std::size_t k = 0; k < of_.driven.size(); ++k) {
      if (!of_.driven[k].has_path()) continue;
      of_.driven[k].begin(clock, step, [&](std::size_t i) { return undriven(k, i); });
    }
  }

  // Called at the end of a sub-step, when poses and anchors are there.
  void keep(const Clock& at) const noexcept {
    if (of_.h == 0) return;
    for_each_part(lists_.size(), [&](const BallList<T>& list, const BallTerms<T>& terms, std::size_t from, std::size_t to) {
      if (!rests(list)) move(list, terms, at, from, std::min(list.count, to));
      kernels_.keep(terms, list.bound, work_, from, to);
    });
    // Later lists may have moved particles of earlier ones. Centers have not moved: no ball moves what it hangs on.
    for_each_part(lists_.size() - 1, [&](const BallList<T>& /*list*/, const BallTerms<T>& terms, std::size_t from,
                                         std::size_t to) { kernels_.prepare(terms, work_, from, to); });
  }

 private:
  static constexpr std::size_t per_task = 2048;  // a fixed number, so that nothing depends on threads

  // List by list, as two may have a particle in common.
  template <class Use>
  void for_each_part(std::size_t lists, const Use& use) const noexcept {
    for (std::size_t n = 0; n < lists; ++n) {
      const BallList<T>& list = lists_[n];
      BallTerms<T> terms = of_.terms[n];
      terms.element = list.element.data();
      terms.r = list.r;
      terms.per_step = static_cast<T>(1 / of_.h);
      for_each_task(parallel_, tasks_of(list.size(), per_task), [&](std::size_t task) {
        const std::size_t from = task * per_task;
        const std::size_t to = std::min(list.size(), from + per_task);
        use(list, terms, from, to);
      });
    }
  }

  // Returns true if its centers stay where they were when the call began.
  [[nodiscard]] bool rests(const BallList<T>& list) const noexcept {
    return list.skin && !of_.skins[*list.skin].motion && !of_.driven[*list.skin].is_driven();
  }

  void move(const BallList<T>& list, const BallTerms<T>& terms, const Clock& at, std::size_t from,
            std::size_t to) const noexcept {
    if (to <= from) return;
    if (!list.skin) return follow_anchors(list, terms, from, to);
    const DrivenSkin& driven = of_.driven[*list.skin];
    if (driven.is_driven()) {
      const Followed of{list, terms, from, to};
      // Centers ascend. If they are consecutive, the loop is vectorised.
      const std::size_t first = list.center[from];
      if (list.center[to - 1] - first == to - 1 - from) {
        follow(driven, at, of, [first, from](std::size_t s) { return first + (s - from); });
      } else {
        follow(driven, at, of, [&list](std::size_t s) { return std::size_t{list.center[s]}; });
      }
    } else {
      follow_start(list, terms, from, to);
    }
  }

  struct Followed {
    const BallList<T>& list;
    const BallTerms<T>& terms;
    std::size_t from, to;
  };
  template <class Number>
  void follow(const DrivenSkin& driven, const Clock& at, const Followed& of, const Number& number) const noexcept {
    const double part = driven.part(at);
    const auto at_moment = [&](const auto& moment) {
      if (of.list.is_backstop()) return follow_behind(driven, moment, of, number);
      follow_points(driven, moment, of, number);
    };
    if (part == 1) return at_moment(driven.at_end());
    at_moment(driven.on_the_way(part));
  }

  template <class Moment, class Number>
  void follow_points(const DrivenSkin& driven, const Moment& moment, const Followed& of, const Number& number) const noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const DrivenSkin::Axis x = driven.points(axis);
      const double origin = of_.origin[axis];
      T* __restrict const c = of.terms.c[axis];
      T* __restrict const u = of.terms.u[axis];
      for (std::size_t s = of.from; s < of.to; ++s) {
        const std::size_t i = number(s);
        c[s] = static_cast<T>(moment(x, i) - origin);
        u[s] = static_cast<T>(x.rate[i]);
      }
    }
  }

  // Some points at a time: first their normals, then each axis, so that both loops are vectorised.
  template <class Moment, class Number>
  void follow_behind(const DrivenSkin& driven, const Moment& moment, const Followed& of, const Number& number) const noexcept {
    constexpr std::size_t together = 128;
    const std::array<DrivenSkin::Axis, 3> m{driven.normals(0), driven.normals(1), driven.normals(2)};
    std::array<std::array<double, together>, 3> n, rate;  // left uninitialised
    for (std::size_t first = of.from; first < of.to; first += together) {
      const std::size_t count = std::min(together, of.to - first);
      for (std::size_t k = 0; k < count; ++k) {
        const std::size_t i = number(first + k);
        const UnitNormal unit({moment(m[0], i), moment(m[1], i), moment(m[2], i)}, {m[0].to[i], m[1].to[i], m[2].to[i]},
                              {m[0].rate[i], m[1].rate[i], m[2].rate[i]});
        for (std::size_t axis = 0; axis < 3; ++axis) {
          n[axis][k] = unit.n[axis];
          rate[axis][k] = unit.rate[axis];
        }
      }
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const DrivenSkin::Axis x = driven.points(axis);
        const double origin = of_.origin[axis];
        const double* const behind = of.list.behind.data() + first;
        T* __restrict const c = of.terms.c[axis] + first;
        T* __restrict const u = of.terms.u[axis] + first;
        for (std::size_t k = 0; k < count; ++k) {
          const std::size_t i = number(first + k);
          c[k] = static_cast<T>((moment(x, i) - behind[k] * n[axis][k]) - origin);
          u[k] = static_cast<T>(x.rate[i] - behind[k] * rate[axis][k]);
        }
      }
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

  // For a skin that nothing has driven yet.
  void follow_start(const BallList<T>& list, const BallTerms<T>& terms, std::size_t from, std::size_t to) const noexcept {
    const Vec3& origin = of_.origin;
    for (std::size_t s = from; s < to; ++s) {
      const SkinPoint point = undriven(*list.skin, list.center[s]);
      const double behind = list.is_backstop() ? list.behind[s] : 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        terms.c[axis][s] = static_cast<T>((point.x[axis] - behind * point.n[axis]) - origin[axis]);
        terms.u[axis][s] = static_cast<T>(point.u[axis] - behind * point.n_rate[axis]);
      }
    }
  }

  [[nodiscard]] SkinPoint undriven(std::size_t skin, std::size_t i) const noexcept {
    const SkinStart& start = of_.skins[skin];
    SkinPoint point{.x = start.points[i]};
    if (!start.normals.empty()) point.n = start.normals[i];
    if (!start.motion) return point;
    const MovedPose& pose = of_.poses[*start.motion];
    point.u = pose.velocity_of(point.x);
    point.x = pose.place(point.x);
    if (start.normals.empty()) return point;
    point.n = turned(pose.turn, point.n);
    point.n_rate = cross(pose.angular_velocity, point.n);
    return point;
  }

  const BallsOfScene<T> of_;
  const WorkColumns<T>& work_;  // as the pulses have left them
  const std::vector<BallList<T>>& lists_;
  const BallKernels<T>& kernels_;
  const ParallelFor& parallel_;
};

}  // namespace dvdx
