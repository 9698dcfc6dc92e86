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

// The value that a birth gets in a column of the caller's own: zeros, or the number of earlier births in all parts, as int64_t
// (8 bytes). Sorted by these numbers, the particles of several parts are in the order in which one plan would keep them.
enum class AtBirth { zeros, number };

// A column of the caller's own that removal moves along with the particles: an id, a colour. Element i lies at
// base + i * stride bytes.
struct Carried {
  void* base = nullptr;
  std::ptrdiff_t stride = 0;  // bytes from an element to the next
  std::size_t bytes = 0;      // of an element; 4 and 8 side by side move fastest
  AtBirth at_birth = AtBirth::zeros;
};

// The live particles are the first state.count. Every column must have room for the turnover's capacity. The struct is a view
// with counts: copying it copies no particle.
template <class T>
struct LiveState {
  State<T> state;
  Column<T> age{};       // s since birth; without a base: not kept
  Column<T> lifetime{};  // s; without a base: none dies of age. Needs `age`
  std::span<const Carried> carried{};
  std::uint64_t born = 0;     // births by the emitters so far; of all parts, if parts share births (dvdx/elsewhere.hpp)
  std::uint64_t removed = 0;  // removals so far, of this part
  std::uint64_t dropped = 0;  // births without room so far, of all parts
};

template <class T>
class LifecyclePlan;

// As Workspace: working memory of one state while a plan steps it, with its driven motions.
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

// Steps as Plan does, by calls of the same names. Each step also ages the particles, removes those that die, keeps the order of
// all others (or fills the holes from the end: SurvivorOrder::any), and appends the births, emitter by emitter. Contacts and
// emitters may follow a motion. The bits do not depend on instruction set, threads, layout or the number of steps a call. Any
// number of threads may step different states with it at once, each with its own clone or workspace.
template <class T>
class DVDX_EXPORT LifecyclePlan {
 public:
  struct Parts;  // private to the library

  explicit LifecyclePlan(Parts* parts) noexcept;  // takes ownership
  LifecyclePlan(LifecyclePlan&&) noexcept;
  LifecyclePlan& operator=(LifecyclePlan&&) noexcept;
  ~LifecyclePlan();

  // Returns too_many_neighbours for particles that meet: the state is then as it was when the failed step began. In these cases
  // nothing is stepped: capacity_too_small if a column has no memory or less room than the turnover's capacity, if the state
  // holds more particles than that, or if lifetimes have no ages; time_not_finite; in_use if another thread steps this plan.
  // Allocates nothing, throws nothing, locks nothing.
  StepResult step(LiveState<T>& live, std::size_t steps = 1, const ParallelFor& parallel = {}) const noexcept;

  // The same, and reports the contacts step by step. A particle's number is its index when its step began.
  StepResult step(LiveState<T>& live, ContactReport& contacts, std::size_t steps = 1,
                  const ParallelFor& parallel = {}) const noexcept;

  // The same in a workspace of the caller's. Returns workspace_differs if a plan of another scene made it or it was moved from,
  // and driven_elsewhere as Plan::step() does.
  StepResult step(LiveState<T>& live, LiveWorkspace<T>& workspace, std::size_t steps = 1,
                  const ParallelFor& parallel = {}) const noexcept;
  StepResult step(LiveState<T>& live, LiveWorkspace<T>& workspace, ContactReport& contacts, std::size_t steps = 1,
                  const ParallelFor& parallel = {}) const noexcept;

  // Removes the particles that the rules name in the present state, without a step. To remove a particle of your choice, make
  // its age infinite.
  StepResult remove(LiveState<T>& live, const ParallelFor& parallel = {}) const noexcept;
  StepResult remove(LiveState<T>& live, LiveWorkspace<T>& workspace, const ParallelFor& parallel = {}) const noexcept;

  // Makes `births` births of emitters[index] at once, at the state's time, behind all live particles, whatever its rate is.
  // Births without room are dropped. Their numbers differ from those of births by time. Particles may also be added by hand:
  // fill the columns behind state.count, ages and lifetimes too, and raise it.
  [[nodiscard]] Expected<void> burst(LiveState<T>& live, std::size_t index, std::size_t births) const;
  [[nodiscard]] Expected<void> burst(LiveState<T>& live, LiveWorkspace<T>& workspace, std::size_t index,
                                     std::size_t births) const;

  // As Plan::clone() and workspace(): driven motions begin by the keys in a clone, and where this plan has them in a workspace.
  // Throw std::bad_alloc if there is no memory.
  [[nodiscard]] LifecyclePlan clone() const;
  [[nodiscard]] LiveWorkspace<T> workspace() const;

  // "Be there at the end of the next step": see Plan::set_pose. Contacts that follow the motion meet particles as in a Plan,
  // and emitters that follow it make their births on the way. A step is one flow: a body should turn by at most half a radian
  // in it.
  [[nodiscard]] Expected<void> set_pose(std::size_t motion, const Pose& target, Arrival arrival = Arrival::moving);

  [[nodiscard]] Expected<void> set_pose(MotionId motion, const Pose& target, Arrival arrival = Arrival::moving) {
    return set_pose(static_cast<std::size_t>(motion), target, arrival);
  }

  // Changes, as Plan's: each changes nothing if it fails. Not while another thread steps with this plan.
  [[nodiscard]] Expected<void> set_step(double h);  // s, > 0: births go on by time
  [[nodiscard]] Expected<void> set_force(std::size_t index, const Force& force);
  // The contact is in place from the next step on. Particles that are then inside leave within that step, or by its push_out. A
  // moving body should follow a motion instead, so that no particle passes through it.
  [[nodiscard]] Expected<void> set_contact(std::size_t index, const Contact& contact);
  // As Plan's, though nothing meets the air here.
  [[nodiscard]] Expected<void> set_wind(const Wind& wind);
  // emitters[index] becomes `emitter` from the next step on, with another place, aim or rate; a rate of 0 switches it off. Its
  // own start and rate determine the births of a step, as if it had always been so. If the rate was higher before, birth
  // numbers repeat, and with them the random values, unless the seed changes.
  [[nodiscard]] Expected<void> set_emitter(std::size_t index, const Emitter& emitter);

  // The same by the ids that add_force() and its like return.
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

  // As Plan::teleport(), for the live particles and all followers of motions. Other emitters and contacts, and boundaries, stay
  // where they are.
  [[nodiscard]] Expected<void> teleport(LiveState<T>& live, const Pose& by) const;
  [[nodiscard]] Expected<void> teleport(LiveState<T>& live, LiveWorkspace<T>& workspace, const Pose& by) const;

  // For particles that meet: returns all data besides the state that the next step depends on, and the targets of motions.
  // Empty if none meet.
  [[nodiscard]] std::vector<double> carried(const LiveState<T>& live) const;
  [[nodiscard]] Expected<void> restore(std::span<const double> carried, const LiveState<T>& live);
  // As Plan's.
  [[nodiscard]] Meetings meetings() const noexcept;
  [[nodiscard]] Meetings meetings(const LiveWorkspace<T>& workspace) const noexcept;

  // As Plan's, for the live particles.
  [[nodiscard]] StateCheck check(const LiveState<T>& live) const noexcept;
  [[nodiscard]] const Scene& scene() const noexcept;
  [[nodiscard]] double step_size() const noexcept;     // s
  [[nodiscard]] const Plan<T>& plan() const noexcept;  // steps the particles; LifecyclePlan alone moves followers of motions
  [[nodiscard]] const Lifecycle& turnover() const noexcept;
  [[nodiscard]] std::string explain() const;  // describes the cost of births and removal in words

 private:
  [[nodiscard]] StepResult fit_of(const LiveWorkspace<T>& workspace) const noexcept;
  Parts* parts_;  // owned
};

template <class T>
using LivePlan [[deprecated("dvdx::LifecyclePlan")]] = LifecyclePlan<T>;

// Compiles a plan for particles that are all alike. Values each, anchors at the start, networks, constraints, fixed and
// kinematic particles are errors that name their field. So is a step that is not > 0, or one in which the keys of a contact's
// motion turn it by more than half a radian. If parts share births, the survivors' order must be kept.
// Balls may meet (Scene::meet), all of one radius, without groups, in one part, with the survivors' order kept. A step then is
// a Plan's step of the live particles, in its sub-steps, before removal and births; a birth meets others from the next step on.
// If it is born inside another ball, the two part no faster than sqrt(g r)/4 (g: the constant acceleration, r: the radius), or
// a tenth of a radius in a step if that is more. Pulses that keep two balls apart follow them when removals renumber them.
// Memory is for `capacity` particles from the start.
template <class T>
[[nodiscard]] DVDX_EXPORT Expected<LifecyclePlan<T>> compile(const Scene& scene, const Lifecycle& turnover,
                                                             const Options& options);

extern template class LiveWorkspace<float>;
extern template class LiveWorkspace<double>;
extern template class LifecyclePlan<float>;
extern template class LifecyclePlan<double>;

}  // namespace dvdx
