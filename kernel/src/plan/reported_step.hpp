// Steps of a plan within the steps of particles that come and go.
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

// Steps a plan within a call that has begun: the caller has checked the arguments and set the floating-point environment.
// Setting it drains the processor: a million particles in calls of 1024 took half as long again. Rounding is plain. run()
// takes plans that join nothing. moved: terms with moved surfaces, for one step, or null. report: null, or takes the contacts
// of the particles, numbered from `first` on.
template <class T>
struct ReportedStep {
  // Steps particles that meet once, in `given`, which a clone may have made, or, if it is null, in the plan's own workspace.
  static StepResult meet(const Plan<T>& plan, Workspace<T>* given, State<T>& state, const ParallelFor& parallel,
                         ContactReport::Parts* report) noexcept;
  // Renumbers particles after removals: after[i] is the new number of particle i, or no_partner if it has gone. count: those
  // left.
  static void renumber(const Plan<T>& plan, Workspace<T>* given, std::span<const std::uint32_t> after,
                       std::size_t count) noexcept;
  // The motions in the plan's own workspace, as the caller drives them.
  static const std::vector<DrivenMotion>& motions_of_meeting(const Plan<T>& plan) noexcept;
  static void run(const Plan<T>& plan, const Terms<T>* moved, State<T>& state, std::size_t steps, ContactReport::Parts* report,
                  std::size_t first) noexcept;
  static const FreeMotion<T>& motion_of(const Plan<T>& plan) noexcept;
};

extern template struct ReportedStep<float>;
extern template struct ReportedStep<double>;

}  // namespace dvdx
