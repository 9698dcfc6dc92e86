// Fixed particles, particles that motions carry and surfaces that follow motions, in one call of step() of joined particles.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "contact/pass/stay.hpp"
#include "contact/surfaces/make_surface.hpp"
#include "plan/joined_call.hpp"

namespace dvdx {

template <class T>
class JoinedFollowers {
 public:
  explicit JoinedFollowers(JoinedCall<T>& call) noexcept
      : call_(call), m_(call.motion), network_(call.network), ws_(call.ws), work_(call.work) {}

  [[nodiscard]] bool is_kinematic(const PinnedState<T>& held) const noexcept {
    return network_.fixed[static_cast<std::size_t>(&held - call_.held.data())].motion.has_value();
  }

  // Called when a call of step() begins.
  void arrive(const Clock& at) noexcept {
    for (std::size_t k = 0; k < ws_.motions.size(); ++k) ws_.motions[k].arrive(m_.tracks()[k], at);
    move(at);
    hold_fixed(0, call_.size());
  }

  // Starts the driven motions and groups on this step's path.
  void begin_driven_paths() noexcept {
    for (std::size_t k = 0; k < ws_.motions.size(); ++k) ws_.motions[k].begin(m_.tracks()[k], call_.clock, network_.step);
    for (const FixedParticle& of : network_.fixed) {
      if (!of.motion || !ws_.groups[of.group].has_path()) continue;
      ws_.groups[of.group].begin(of.index, ws_.poses[*of.motion].place(of.place), network_.step);
    }
    for (DrivenPlaces& group : ws_.groups) {
      if (group.has_path()) group.begin(call_.clock, network_.step);
    }
  }

  // Puts kinematic particles where their motions have them at this time.
  void move(const Clock& at) noexcept {
    if (m_.tracks().empty()) return;
    for (std::size_t k = 0; k < m_.tracks().size(); ++k) ws_.poses[k] = ws_.motions[k].at(m_.tracks()[k], at);
    const Vec3& origin = m_.origin();
    for (std::size_t n = 0; n < network_.fixed.size(); ++n) {
      const FixedParticle& of = network_.fixed[n];
      if (!of.motion) continue;
      PinnedState<T>& held = call_.held[n];
      const MovedPose& pose = ws_.poses[*of.motion];
      const DrivenPlaces& driven = ws_.groups[of.group];
      const Vec3 x = driven.is_driven() ? driven.place(of.index, at) : pose.place(of.place);
      const Vec3 u = driven.is_driven() ? driven.velocity(of.index) : pose.velocity_of(of.place);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        held.x[axis] = static_cast<T>(x[axis] - origin[axis]);
        held.v[axis] = static_cast<T>(u[axis]);
      }
    }
  }

  void hold_fixed(std::size_t from, std::size_t to) noexcept {
    auto held = std::lower_bound(call_.held.begin(), call_.held.end(), from,
                                 [](const PinnedState<T>& h, std::size_t element) { return h.element < element; });
    for (; held != call_.held.end() && held->element < to; ++held) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        work_.x[axis][held->element] = call_.is_relative() ? way_in_step(*held, axis) : held->x[axis];
        work_.v[axis][held->element] = is_kinematic(*held) ? held->v[axis] : T(0);
      }
    }
  }

  // Makes the current positions the ones that later positions are counted from.
  void rebase_origin() noexcept {
    call_.for_each_stepped(
        [&](std::size_t from, std::size_t end) { call_.kernels.move_origin(ws_.origin, work_.x, from, end); });
    for (const PinnedState<T>& held : call_.held) {
      for (std::size_t axis = 0; axis < 3 && is_kinematic(held); ++axis) ws_.origin[axis][held.element] = held.x[axis];
    }
  }

  // ---- surfaces ----------------------------------------------------------------------------------------------------------

  // The flow's terms with its surfaces moved. Valid after move_surfaces() if surfaces move.
  [[nodiscard]] const Terms<T>& moved_terms() const noexcept { return moved_terms_; }

  // Moves the surfaces of the flow from `start` to `end`.
  void move_surfaces(const FreeMotion<T>& motion, const Clock& start, const Clock& end) noexcept {
    if (ws_.surfaces.empty()) return;
    moved_terms_ = motion.terms;
    if (motion.terms.surface_count == 0) return;
    moved_terms_.surfaces = ws_.surfaces.data();
    std::fill(ws_.movers.begin(), ws_.movers.end(), no_surface);
    for (std::size_t j = 0; j < ws_.surfaces.size(); ++j) {
      Surface<T>& surface = ws_.surfaces[j];
      surface = motion.terms.surfaces[j];
      const Contact& contact = m_.contacts()[surface.contact];
      const auto& of = motion_of(contact);
      if (!of) continue;
      const MovedPose pose = ws_.motions[*of].at_end_of(m_.tracks()[*of], start, end);
      move_surface(surface, contact, pose, m_.origin());
      if (call_.report != nullptr) call_.report->centers[surface.contact] = {pose.place(pose.center), pose.velocity};
      if (surface.movement == Movement::rest) continue;
      moved_terms_.moves = true;
      ws_.movers[*of] = static_cast<std::uint32_t>(j);
    }
  }

 private:
  // 0 for a fixed particle, whose position may be infinite.
  [[nodiscard]] T way_in_step(const PinnedState<T>& held, std::size_t axis) const noexcept {
    return is_kinematic(held) ? held.x[axis] - ws_.origin[axis][held.element] : T(0);
  }

  JoinedCall<T>& call_;
  const JoinedMotion<T>& m_;
  const CompiledNetwork<T>& network_;
  JoinedWorkspace<T>& ws_;
  WorkColumns<T>& work_;
  Terms<T> moved_terms_;  // of the flow, if surfaces move
};

}  // namespace dvdx
