// A plan for particles that come and go.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "dvdx/export.h"
#include "dvdx/layouts/state.hpp"
#include "dvdx/plan.hpp"
#include "dvdx/turnover.hpp"

namespace dvdx {

// The value that a birth gets in a column of the caller's own: zeros, or how many births of all parts there were before it, as
// int64_t (of 8 bytes). By these numbers the particles that parts share stand in the order in which one plan would keep them.
enum class AtBirth { zeros, number };

// A column of the caller's own that removal moves along with the particles: an id, a colour. Element i stands at
// base + i * stride bytes.
struct Carried {
  void* base = nullptr;
  std::ptrdiff_t stride = 0;  // bytes from an element to the next
  std::size_t bytes = 0;      // of an element; 4 and 8 side by side move fastest
  AtBirth at_birth = AtBirth::zeros;
};

// The live particles are the first state.count; every column must have room for the turnover's capacity. Only pointers and
// counts: copying it copies no particle.
template <class T>
struct LiveState {
  State<T> state;
  Column<T> age{};       // s since birth; without a base: not kept
  Column<T> lifetime{};  // s; without a base: none dies of age. Needs `age`
  std::span<const Carried> carried{};
  std::uint64_t born = 0;     // so far, by the emitters: of all parts, where some share births (dvdx/elsewhere.hpp)
  std::uint64_t removed = 0;  // so far: of this part
  std::uint64_t dropped = 0;  // births that found no room: of all parts
};

template <class T>
class LifecyclePlan;

// As Workspace: the memory that one state works in while a plan steps it, and what drives it.
template <class T>
class DVDX_EXPORT LiveWorkspace {
 public:
  LiveWorkspace(LiveWorkspace&&) noexcept;
  LiveWorkspace& operator=(LiveWorkspace&&) noexcept;
  ~LiveWorkspace();
  [[nodiscard]] std::size_t bytes() const noexcept;
  // As LifecyclePlan's, for the state that is stepped in this workspace.
  [[nodiscard]] Expected<void> set_pose(std::size_t motion, const Pose& target, Arrival arrival = Arrival::moving);
  [[nodiscard]] Expected<void> set_pose(MotionId motion, const Pose& target, Arrival arrival = Arrival::moving) {
    return set_pose(static_cast<std::size_t>(motion), target, arrival);
  }

 private:
  friend class LifecyclePlan<T>;
  struct Parts;
  explicit LiveWorkspace(Parts* parts) noexcept;
  Parts* parts_;  // owned
};

// Steps as Plan does, by calls of the same names: lets particles age, removes those that are to go, keeps the order of all
// others (or fills the holes from the end: SurvivorOrder::any), and lets the births of each step follow behind them, emitter by
// emitter. Contacts and emitters may follow a motion. The bits do not depend on the instruction set, on threads, on the layout
// or on how many steps a call takes. Any number of threads may step different states with it at once, each with its own clone
// or workspace.
template <class T>
class DVDX_EXPORT LifecyclePlan {
 public:
  struct Parts;  // private to the library

  explicit LifecyclePlan(Parts* parts) noexcept;  // which it owns from then on
  LifecyclePlan(LifecyclePlan&&) noexcept;
  LifecyclePlan& operator=(LifecyclePlan&&) noexcept;
  ~LifecyclePlan();

  // too_many_neighbours of particles that meet: where a step has not ended, the state is as it was when that step began.
  // capacity_too_small where a column has no memory or less room than the turnover's capacity, the state holds more particles
  // than that, or lifetimes have no ages; time_not_finite; in_use where another thread steps this plan. Then nothing was
  // stepped. Allocates nothing, throws nothing, locks nothing.
  StepResult step(LiveState<T>& live, std::size_t steps = 1, const ParallelFor& parallel = {}) const noexcept;

  // The same, and reports what contacts do, step by step. A particle's number is where it stood when its step began.
  StepResult step(LiveState<T>& live, ContactReport& contacts, std::size_t steps = 1,
                  const ParallelFor& parallel = {}) const noexcept;

  // The same in a workspace of the caller's: workspace_differs where another scene's plan made it or it was moved from,
  // driven_elsewhere as Plan::step().
  StepResult step(LiveState<T>& live, LiveWorkspace<T>& workspace, std::size_t steps = 1,
                  const ParallelFor& parallel = {}) const noexcept;
  StepResult step(LiveState<T>& live, LiveWorkspace<T>& workspace, ContactReport& contacts, std::size_t steps = 1,
                  const ParallelFor& parallel = {}) const noexcept;

  // Removes what is to go as the particles stand, and moves nothing on. To remove one of your own choice, make its age
  // infinite.
  StepResult remove(LiveState<T>& live, const ParallelFor& parallel = {}) const noexcept;
  StepResult remove(LiveState<T>& live, LiveWorkspace<T>& workspace, const ParallelFor& parallel = {}) const noexcept;

  // So many births of emitters[index] at once, at the state's time and behind all that live, whatever its rate is; those that
  // find no room are dropped. Their numbers are others than those of births by time. A state may also be given particles by
  // hand: fill the columns behind state.count, ages and lifetimes too, and raise it.
  [[nodiscard]] Expected<void> burst(LiveState<T>& live, std::size_t index, std::size_t births) const;
  [[nodiscard]] Expected<void> burst(LiveState<T>& live, LiveWorkspace<T>& workspace, std::size_t index,
                                     std::size_t births) const;

  // As Plan::clone() and workspace(): what drives things begins by the keys in a clone, and where this plan has it in a
  // workspace. Throw std::bad_alloc where there is no memory.
  [[nodiscard]] LifecyclePlan clone() const;
  [[nodiscard]] LiveWorkspace<T> workspace() const;

  // "Be there at the end of the next step": see Plan::set_pose. Contacts that follow the motion meet particles as a Plan's do,
  // and emitters that follow it make their births on the way. A step is one flow: a body should not turn by more than half a
  // radian in it.
  [[nodiscard]] Expected<void> set_pose(std::size_t motion, const Pose& target, Arrival arrival = Arrival::moving);

  [[nodiscard]] Expected<void> set_pose(MotionId motion, const Pose& target, Arrival arrival = Arrival::moving) {
    return set_pose(static_cast<std::size_t>(motion), target, arrival);
  }

  // Changes, as Plan's: each changes nothing where it fails. Not while another thread steps with this plan.
  [[nodiscard]] Expected<void> set_step(double h);  // s, > 0: births go on by time
  [[nodiscard]] Expected<void> set_force(std::size_t index, const Force& force);
  // The contact is there from the next step on: what it then holds inside leaves it within that step, or by its push_out. A
  // body that moves follows a motion, so that it passes nothing.
  [[nodiscard]] Expected<void> set_contact(std::size_t index, const Contact& contact);
  // As Plan's, though nothing meets the air here.
  [[nodiscard]] Expected<void> set_wind(const Wind& wind);
  // emitters[index] becomes `emitter` from the next step on: moved, aimed elsewhere, with another rate; a rate of 0 switches it
  // off. Which births the step has is told by its own start and rate, as if it had always been so: where its rate was higher
  // before, numbers that were drawn come again, unless its seed is another one.
  [[nodiscard]] Expected<void> set_emitter(std::size_t index, const Emitter& emitter);

  // By what add_force() and its like have returned.
  [[nodiscard]] Expected<void> set_force(ForceId id, const Force& force) {
    return set_force(static_cast<std::size_t>(id), force);
  }
  [[nodiscard]] Expected<void> set_contact(ContactId id, const Contact& contact) {
    return set_contact(static_cast<std::size_t>(id), contact);
  }
  [[nodiscard]] Expected<void> set_emitter(EmitterId id, const Emitter& emitter) {
    return set_emitter(static_cast<std::size_t>(id), emitter);
  }
  [[nodiscard]] Expected<void> burst(LiveState<T>& live, EmitterId id, std::size_t births) const {
    return burst(live, static_cast<std::size_t>(id), births);
  }

  // As Plan::teleport(), of the particles that live and of what follows a motion. Other emitters and contacts, and boundaries,
  // stay where they are.
  [[nodiscard]] Expected<void> teleport(LiveState<T>& live, const Pose& by) const;
  [[nodiscard]] Expected<void> teleport(LiveState<T>& live, LiveWorkspace<T>& workspace, const Pose& by) const;

  // All that the next step of particles that meet depends on beside the state, and where motions were told to go. Empty
  // where none meet.
  [[nodiscard]] std::vector<double> carried(const LiveState<T>& live) const;
  [[nodiscard]] Expected<void> restore(std::span<const double> carried, const LiveState<T>& live);
  // As Plan's.
  [[nodiscard]] Meetings meetings() const noexcept;
  [[nodiscard]] Meetings meetings(const LiveWorkspace<T>& workspace) const noexcept;

  // As Plan's, of the particles that live.
  [[nodiscard]] StateCheck check(const LiveState<T>& live) const noexcept;
  [[nodiscard]] const Scene& scene() const noexcept;
  [[nodiscard]] double step_size() const noexcept;     // s
  [[nodiscard]] const Plan<T>& plan() const noexcept;  // of the particles; LifecyclePlan alone steps what follows a motion
  [[nodiscard]] const Lifecycle& turnover() const noexcept;
  [[nodiscard]] std::string explain() const;  // what coming and going costs, in words

 private:
  [[nodiscard]] StepResult fit_of(const LiveWorkspace<T>& workspace) const noexcept;
  Parts* parts_;  // owned
};

template <class T>
using LivePlan [[deprecated("dvdx::LifecyclePlan")]] = LifecyclePlan<T>;

// A plan for particles that are all alike: values each, anchors at the start, networks, constraints, fixed and kinematic
// particles are errors that name their field, and so is a step that is not > 0, or one in which the keys of a contact's motion
// turn it by more than half a radian. Where parts share births the survivors' order must be kept.
// Balls may meet (Scene::meet), all of one radius, in one group and one part, the survivors' order kept. A step then is one of
// Plan for those that live, in its sub-steps, before births and removal; a birth meets others from the next step on. Where it
// is within another, the two part slowly: no faster than sqrt(g r)/4 (g: the constant acceleration, r: the radius), or a tenth
// of a radius in a step where that is more. Pulses that keep two apart go with them when others before them are removed.
// Memory is for `capacity` particles from the first.
template <class T>
[[nodiscard]] DVDX_EXPORT Expected<LifecyclePlan<T>> compile(const Scene& scene, const Lifecycle& turnover,
                                                             const Options& options);

extern template class LiveWorkspace<float>;
extern template class LiveWorkspace<double>;
extern template class LifecyclePlan<float>;
extern template class LifecyclePlan<double>;

}  // namespace dvdx
