// Steps of plans within steps of particles that come and go.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "contact/report/contact_recorder.hpp"
#include "dvdx/plan.hpp"
#include "free/free_motion.hpp"
#include "motion/driven.hpp"

namespace dvdx {

// The step of a plan that joins nothing, of plain rounding, within a call that has begun: what is wrong has been looked for,
// and the environment is a step's. To set it drains the processor: a million particles took half as long again in calls of
// 1024. moved: null, or terms with surfaces moved, of one step. report: null, or what is told of the particles from number
// `first` on.
template <class T>
struct ReportedStep {
  // A step of particles that meet as well: in the plan's own workspace, or in one that its like made.
  static StepResult meet(const Plan<T>& plan, Workspace<T>* given, State<T>& state, const ParallelFor& parallel,
                         ContactReport::Parts* report) noexcept;
  // Some of them have gone: after[i] is the number of particle i from now on, or no_partner; `count` are left.
  static void renumber(const Plan<T>& plan, Workspace<T>* given, std::span<const std::uint32_t> after,
                       std::size_t count) noexcept;
  // Where its motions have been told to go.
  static const std::vector<DrivenMotion>& motions_of_meeting(const Plan<T>& plan) noexcept;
  static void run(const Plan<T>& plan, const Terms<T>* moved, State<T>& state, std::size_t steps, ContactReport::Parts* report,
                  std::size_t first) noexcept;
  static const FreeMotion<T>& motion_of(const Plan<T>& plan) noexcept;
};

extern template struct ReportedStep<float>;
extern template struct ReportedStep<double>;

}  // namespace dvdx
