// A plan: a scene compiled for one step size, one scalar type and one instruction set.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "dvdx/contact_report.hpp"
#include "dvdx/elsewhere.hpp"
#include "dvdx/export.h"
#include "dvdx/isa.hpp"
#include "dvdx/layouts/memory.hpp"
#include "dvdx/layouts/state.hpp"
#include "dvdx/parallel.hpp"
#include "dvdx/scene.hpp"

namespace dvdx {

// An error in a scene, an option or a state: the field ("forces[2].stiffness"), its value, and the valid values.
struct Error {
  std::string field;
  std::string value;
  std::string valid;
  [[nodiscard]] DVDX_EXPORT std::string message() const;
};

template <class T>
using Expected = tl::expected<T, Error>;

// Treatment of the digits of a step's result that the state's scalar type cannot hold.
enum class Rounding {
  plain,  // they are lost
  // For float32 states alone: the digits are kept in the state's residual columns, and the step is computed in float64. The
  // numbers are those of a float64 step to 48 bits; x and v stay readable float32 columns. The cost is a float64 step and, once
  // a call, the conversion to float64 and back (bench/compensated_bench.cpp). Kahan's sums in float32 lanes would cost less for
  // one step a call, but leave the coefficients' rounding, which grows faster than the state's (docs/precision.md).
  compensated,
};

// Treatment of springs between particles if the scene asks for fewer sub-steps than stability needs.
enum class Unstable {
  refused,  // compile() and set_step() return an error that names the fewest
  allowed,  // they are stepped, and may grow without bound: for studies of instability
};

struct Options {
  double step = 1.0 / 60;  // s, finite; negative runs time backwards, and a step of 0 changes no bit
  // s, finite and > 0: steps vary, as frames do. Springs by `sequential` are then solved for the sub-step of this step: a
  // longer step takes more sub-steps, and a shorter one is as exact as this one, no more. None: all steps have one length until
  // set_step() gives another; from then on longest_step is the length that the plan was compiled for. Compile a plan for
  // varying frames with the usual frame time; compile anew if the step changes for good.
  std::optional<double> longest_step{};
  std::optional<Isa> isa{};  // none: the one of DVDX_ISA, else the best: see forced_isa()
  Arithmetic arithmetic = Arithmetic::separate;
  std::size_t block = 0;  // particles that stay in first-level cache together: a multiple of 16, at most 1024; 0: chosen
  Rounding rounding = Rounding::plain;
  int impacts = 32;  // 1..1000: impacts of one particle that one step resolves in time order; the rest is clamped
  Unstable unstable = Unstable::refused;
  // Allocator of the plan's columns: the memory with a number for each particle, spring or constraint that a step reads or
  // works in. The scene's copy and its lists come from operator new. If either has none left, std::bad_alloc is thrown.
  Memory memory{};
  PartContext elsewhere{};  // for a state that is stepped in parts
};

// An attribute of an enumeration is beyond the formatter:
// clang-format off
enum class [[nodiscard]] StepResult {
  done,
  count_differs,       // the plan holds values per particle, and the state has another count: nothing was stepped
  capacity_too_small,  // a column (in compensated plans a residual column too) has no memory or a capacity below the state's
                       // count: nothing was stepped
  in_use,              // another thread steps with this plan's own workspace, or with the one given: nothing was stepped
  workspace_differs,   // the workspace given is moved from, or was made for a scene with other particles, another scheme, other
                       // networks, constraints or driven things: nothing was stepped. Other steps, sub-steps and numbers are
                       // no obstacle
  report_differs,      // the report given is for another number of contacts: nothing was stepped
  time_not_finite,     // the state's clock is infinite or not a number: nothing was stepped
  // set_pose or its like gave the plan a target after the workspace was made, and the workspace was never driven itself:
  // nothing was stepped. Drive the workspace, or use an Instance for the state (dvdx/instance.hpp).
  driven_elsewhere,
  moved_from,          // the plan, or the instance, was moved from: there is nothing to step by
  // More than Meet::most_neighbours particles came within reach of one. The state and its clock are those of the call's start.
  // Driven motions, groups and skins have gone to their targets; nothing is carried on, as after forget().
  too_many_neighbours,
};
// clang-format on

// Estimated error of the net that sweeps step worst: sweeps leave springs softer than the scene's. It follows from the springs,
// the masses, the held particles and the scene's constant accelerations; all 0 if nothing hangs on held particles.
struct SweepEstimate {
  double side = 0;    // m: distance from the held particles to the farthest one, along the springs at rest
  double sag = 0;     // m: stretch of exact springs under the load
  double rest = 0;    // m: by how much the net hangs too low
  double motion = 0;  // m: error of a swing
  // Frequency with which a net's springs turn under their load, times the sub-step, if lines are solved. Beyond most_turning a
  // sheet that falls into place may not come to rest, but swing on at some tenths of a m/s.
  double turning = 0;
  double most_turning = 0;
};

// The scheme that `automatic` became, with each scheme's sub-steps a step and its ns a step by the table of costs.
struct SchemeChoice {
  Scheme scheme = Scheme::leapfrog;
  int leapfrog = 1, sequential = 1;
  double leapfrog_cost = 0, sequential_cost = 0;
};

// The limit of the sub-steps of a scene's networks.
struct NetworkLimit {
  int substeps = 1;            // a step, chosen or asked for
  double frequency = 0;        // rad/s: the highest of the springs in their start position, by Lanczos' iteration
  double bound = 0;            // rad/s: no position of the particles has a higher frequency
  double limit = 0;            // frequency times sub-step that the scheme allows; infinite for sequential
  int fewest = 1;              // sub-steps a step below which compile() refuses: for a grid without contacts, those stable at
                               // the start's frequency and 7 % more; else `safe`
  int safe = 1;                // sub-steps a step that are stable in any position. "auto" takes the fewest that also keep the
                               // energy of linear springs within half and twice of its value
  std::uint32_t particle = 0;  // the one whose springs set the bound
  double damping = 0;          // 1/s: no position of the particles has a higher rate of damping along the springs
  double damping_limit = 0;    // that rate times sub-step that the scheme allows; infinite for sequential
  double rho = 0;              // sequential's generalized alpha: the part of a stiff motion that a sub-step leaves
  Scheme scheme = Scheme::leapfrog;      // by which the plan steps
  SweepEstimate estimate{};              // for sequential
  std::optional<SchemeChoice> choice{};  // if the scene left the scheme open
};

// The condition of a state: Plan::check().
struct StateCheck {
  // count_differs, capacity_too_small or moved_from: nothing was examined. Otherwise done.
  StepResult result = StepResult::done;
  // The largest ratio of length to rest length of any whole spring. Springs without stiffness or rest length do not count, nor
  // do springs whose length is NaN. 0: there is none.
  double stretch = 0;
  std::size_t network = 0;  // the network of that spring
  Pair spring{};            // its ends, the lesser number first
  // The largest violation of a Distance constraint, as part of its length. 0: all hold.
  double off = 0;
  std::size_t constraint = 0;
  Pair rod{};
  // J: kinetic of particles that are neither fixed nor kinematic, elastic of whole springs, weight of the same particles in all
  // constant forces, zero at the world's origin. Springs to anchors, drag and time-dependent forces are left out. A sum is NaN
  // if a particle's term is.
  double kinetic = 0, elastic = 0, weight = 0;
  std::size_t not_finite = 0;        // particles whose place or velocity is infinite or NaN, fixed ones too
  std::size_t first_not_finite = 0;  // if there are any
};

template <class T>
class Plan;
template <class T>
class Instance;  // dvdx/instance.hpp
template <class T>
struct ReportedStep;  // private to the library

// Working memory of one state while a plan steps it. It is empty for a scene without networks, constraints, skins, kinematic
// particles, particles that meet and contacts that follow a motion. One workspace may serve many states, one after the other.
// Two things are carried on in it from step to step: the springs' accelerations of networks by sequential without theta, and
// the pulses between particles that meet. If a state's columns and clock are not those that the last step left, the next step
// starts without both, by a sub-step of first order. Such a state should have a workspace, or a plan, of its own.
template <class T>
class DVDX_EXPORT Workspace {
 public:
  Workspace(Workspace&&) noexcept;
  Workspace& operator=(Workspace&&) noexcept;
  ~Workspace();
  [[nodiscard]] std::size_t bytes() const noexcept;
  // As Plan::forget().
  void forget() noexcept;
  // As Plan's, for the state that is stepped in this workspace.
  [[nodiscard]] Expected<void> set_pose(std::size_t motion, const Pose& target, Arrival arrival = Arrival::moving);
  [[nodiscard]] Expected<void> set_places(std::size_t kinematic, std::span<const Vec3> places,
                                          Arrival arrival = Arrival::moving);
  [[nodiscard]] Expected<void> set_skin(std::size_t skin, std::span<const Vec3> points, std::span<const Vec3> normals = {},
                                        Arrival arrival = Arrival::moving);
  // The same by the ids that add_body() and its like return; likewise below.
  [[nodiscard]] Expected<void> set_pose(MotionId motion, const Pose& target, Arrival arrival = Arrival::moving) {
    return set_pose(static_cast<std::size_t>(motion), target, arrival);
  }
  [[nodiscard]] Expected<void> set_places(PinsId pins, std::span<const Vec3> places, Arrival arrival = Arrival::moving) {
    return set_places(static_cast<std::size_t>(pins), places, arrival);
  }
  [[nodiscard]] Expected<void> set_skin(SkinId skin, std::span<const Vec3> points, std::span<const Vec3> normals = {},
                                        Arrival arrival = Arrival::moving) {
    return set_skin(static_cast<std::size_t>(skin), points, normals, arrival);
  }

 private:
  friend class Plan<T>;
  friend struct ReportedStep<T>;
  struct Parts;
  explicit Workspace(Parts* parts) noexcept;
  Parts* parts_;  // owned
};

// T is float or double. A plan is a compiled scene, shared with its clones, and a workspace of its own. Any number of threads
// may step different states with it at once, each with its own clone or workspace; scenes whose Workspace is empty need
// neither. No thread may step while a change runs.
template <class T>
class DVDX_EXPORT Plan {
 public:
  struct Parts;  // private to the library

  explicit Plan(Parts* parts) noexcept;  // takes ownership
  Plan(Plan&&) noexcept;
  Plan& operator=(Plan&&) noexcept;
  ~Plan();

  // Returns a plan of the same compiled scene with a workspace of its own, for another state: nothing is compiled again. A
  // later change of one does not change the other. Throws std::bad_alloc if there is no memory.
  [[nodiscard]] Plan clone() const;
  // Returns working memory for step() below. Driven things in it begin where this plan has them. Throws likewise.
  [[nodiscard]] Workspace<T> workspace() const;
  // Joins a state with a workspace, driven things, wind and frame time of its own. Include dvdx/instance.hpp. Returns an error
  // if a step would refuse the state. Throws std::bad_alloc.
  [[nodiscard]] Expected<Instance<T>> instance(const State<T>& state) const;

  // Moves every particle and the state's clock by `steps` steps; a block of particles takes all steps while it is in cache. A
  // call of no steps puts kinematic particles where their motions have them at the state's time. Allocates nothing, throws
  // nothing, locks nothing. Denormals are flushed to zero meanwhile; the caller's floating-point environment is restored.
  StepResult step(State<T>& state, std::size_t steps = 1, const ParallelFor& parallel = {}) const noexcept;
  // The same in a workspace of the caller's, made by this plan or a clone. Returns workspace_differs if a change since then
  // needs another one, and driven_elsewhere if set_pose or its like gave a target to this plan and not to that workspace. The
  // bits do not depend on the workspace, except through the things that it carries on.
  StepResult step(State<T>& state, Workspace<T>& workspace, std::size_t steps = 1,
                  const ParallelFor& parallel = {}) const noexcept;
  // The same, and reports the scene's contacts. The bits are those of a step without a report. Particles that touch a surface
  // are resolved one by one meanwhile; all others are as fast as ever.
  StepResult step(State<T>& state, ContactReport& contacts, std::size_t steps = 1,
                  const ParallelFor& parallel = {}) const noexcept;
  StepResult step(State<T>& state, Workspace<T>& workspace, ContactReport& contacts, std::size_t steps = 1,
                  const ParallelFor& parallel = {}) const noexcept;

  // Drops the springs' and contacts' history of the last step (see Workspace). Call it after a jump of the state, as by a
  // teleport of some of its particles. It is not needed for another state or clock, nor if all particles are moved alike,
  // kicked or stepped with another step.
  void forget() noexcept;

  // Returns all data that the next step depends on besides the state's columns and clock: the things that a Workspace carries
  // on, and the targets of set_pose, set_places and set_skin. With them a stored state goes on elsewhere with the same bits: in
  // a plan of the same scene, compiled for the same start, on any instruction set. The numbers are for restore() alone; few or
  // none if there is nothing to keep. Not while another thread steps with this plan, or in this workspace.
  [[nodiscard]] std::vector<double> carried(const State<T>& state) const;
  [[nodiscard]] std::vector<double> carried(const State<T>& state, const Workspace<T>& workspace) const;
  // Takes the numbers of carried(). The state must have the same count, columns and clock as then. Changes nothing if it fails.
  [[nodiscard]] Expected<void> restore(std::span<const double> carried, const State<T>& state);
  [[nodiscard]] Expected<void> restore(std::span<const double> carried, const State<T>& state, Workspace<T>& workspace) const;

  // The same motion `steps` steps ahead by powers of the step's matrix. Only for scenes without networks, constraints,
  // contacts, radial springs, skins, meet, fixed and kinematic particles; the error names the obstacle.
  [[nodiscard]] Expected<void> seek(State<T>& state, std::uint64_t steps) const;

  // "Be there at the end of the next step", whichever call makes it. The followers of motions[motion], or the particles of
  // kinematic[kinematic], go there on a straight line (a pose also turns evenly, the short way round). In every sub-step they
  // are on it and have its velocity. After the step they rest until the next target. The motion's keys no longer count. Nothing
  // is compiled; set_places takes memory at its first call. Both drive the state that is stepped in the plan's own workspace.
  // Workspaces made later start from there; a clone starts by the keys. Not while another thread steps with this plan.
  // By Arrival::jump the followers are there when the next step begins; nothing between is swept, and a waiting target is
  // dropped. They rest in that step, unless a target by Arrival::moving is set before it: then they move on to that target. So
  // a walking character that is carried elsewhere first jumps to its carried old place and then moves to the new one. The
  // program carries the state's own positions along.
  [[nodiscard]] Expected<void> set_pose(std::size_t motion, const Pose& target, Arrival arrival = Arrival::moving);
  // places: m, in the world, one for each particle
  [[nodiscard]] Expected<void> set_places(std::size_t kinematic, std::span<const Vec3> places,
                                          Arrival arrival = Arrival::moving);
  // Likewise for skins[skin]: one point (m, in the world) and one normal (of any length > 0) for each of its particles. Without
  // normals those of the back-stop stay; a skin without back-stop takes none. Takes no memory.
  [[nodiscard]] Expected<void> set_skin(std::size_t skin, std::span<const Vec3> points, std::span<const Vec3> normals = {},
                                        Arrival arrival = Arrival::moving);
  [[nodiscard]] Expected<void> set_pose(MotionId motion, const Pose& target, Arrival arrival = Arrival::moving) {
    return set_pose(static_cast<std::size_t>(motion), target, arrival);
  }
  [[nodiscard]] Expected<void> set_places(PinsId pins, std::span<const Vec3> places, Arrival arrival = Arrival::moving) {
    return set_places(static_cast<std::size_t>(pins), places, arrival);
  }
  [[nodiscard]] Expected<void> set_skin(SkinId skin, std::span<const Vec3> points, std::span<const Vec3> normals = {},
                                        Arrival arrival = Arrival::moving) {
    return set_skin(static_cast<std::size_t>(skin), points, normals, arrival);
  }

  // Carries a state elsewhere by one rigid motion of the world, x to R x + translation (R about the world's origin). Positions,
  // velocities, the springs' history, fixed particles, and everything that follows a motion or is driven go along. Keys of
  // motions go on from there. Waiting targets are carried along; later ones are in the world, as ever. No speed changes, and
  // nothing between is swept. Places and directions that the scene names in the world stay: contacts that follow no motion,
  // anchors of forces, also those at the start, and the directions of forces and wind. Particles at infinity stay there. Takes
  // no memory except for an error. Not while another thread steps with this plan, or in this workspace.
  // Returns an error and changes nothing: if `by` is not finite or a step would refuse the state; if a constraint holds a
  // particle on a point or a line of the world, which would draw it back; or if T rounds the new places, from the scene's
  // origin, by more than 1/64 of the shortest spring or rod.
  [[nodiscard]] Expected<void> teleport(State<T>& state, const Pose& by);
  [[nodiscard]] Expected<void> teleport(State<T>& state, Workspace<T>& workspace, const Pose& by) const;

  // Returns the lengths of springs and rods, the energy, and whether all of it is finite, at any time. Makes one pass over the
  // particles and one over springs and rods; allocates nothing, throws nothing, and runs on any thread.
  [[nodiscard]] StateCheck check(const State<T>& state) const noexcept;

  // How particles met in the last sub-step in this plan's own workspace, or in the given one. Before the first sub-step
  // stretch_limit and passing_layers alone are set. All 0 for a scene without `meet`.
  [[nodiscard]] Meetings meetings() const noexcept;
  [[nodiscard]] Meetings meetings(const Workspace<T>& workspace) const noexcept;

  // Changes of the scene. Each recomputes the parts that it touches. If it fails, with an error or with std::bad_alloc, it
  // changes nothing. Not while another thread steps with this plan; clones keep their scene. The plan then steps as one
  // compiled anew from scene() and the first start: scene() holds the scheme and the longest sub-step that were chosen at
  // first, and rest lengths and anchors at the start stay. set_step() makes steps vary (Options::longest_step): the plan is
  // then the one that compile() makes with step_size() and longest_step().
  // If a step h needs more sub-steps than Coupling::most_substeps, set_step() takes the longest step of h's sign that these
  // keep stable. step_size() then is shorter than h, and the rest of the time is left out.
  [[nodiscard]] Expected<void> set_step(double h);
  // forces[index] becomes `force`.
  [[nodiscard]] Expected<void> set_force(std::size_t index, const Force& force);
  // contacts[index] becomes `contact`: its pose and all its numbers. It cannot get a motion in a plan that was compiled without
  // networks, constraints, skins, meet and followers of a motion.
  [[nodiscard]] Expected<void> set_contact(std::size_t index, const Contact& contact);
  // networks[index] becomes `network`: stiffness, zero_length, damping and aerodynamics may differ; the kind, the particles,
  // rest lengths and triangles must not. Torn springs stay torn.
  [[nodiscard]] Expected<void> set_network(std::size_t index, const Network& network);
  [[nodiscard]] Expected<void> set_force(ForceId id, const Force& force) {
    return set_force(static_cast<std::size_t>(id), force);
  }
  [[nodiscard]] Expected<void> set_contact(ContactId id, const Contact& contact) {
    return set_contact(static_cast<std::size_t>(id), contact);
  }
  [[nodiscard]] Expected<void> set_network(NetworkId id, const Network& network) {
    return set_network(static_cast<std::size_t>(id), network);
  }
  [[deprecated("set_force")]] Expected<void> replace(std::size_t index, const Force& force) { return set_force(index, force); }
  [[deprecated("set_contact")]] Expected<void> replace(std::size_t index, const Contact& contact) {
    return set_contact(index, contact);
  }
  // Sets the air that networks with `aerodynamics` meet. Takes memory only for more gusts than before.
  [[nodiscard]] Expected<void> set_wind(const Wind& wind);
  // Sets every spring of networks[index], a Grid or Springs, that is not torn. Lengths stay.
  [[nodiscard]] Expected<void> set_stiffness(std::size_t index, const GridStiffness& stiffness);
  [[nodiscard]] Expected<void> set_stiffness(std::size_t index, const SpringsStiffness& stiffness);
  template <class Stiffness>
  [[nodiscard]] Expected<void> set_stiffness(NetworkId id, const Stiffness& stiffness) {
    return set_stiffness(static_cast<std::size_t>(id), stiffness);
  }
  // Sets the zero_length of networks[index], Springs: N/m, one for all or one a pair. Lengths and stiffness stay.
  [[nodiscard]] Expected<void> set_zero_length(std::size_t index, const Scalars& zero_length);
  // The same by angles: replaces all zero_length by the values of add_bending() (dvdx/bending.hpp). The network must already
  // have all pairs that add_bending() uses: call add_bending() before compile(), if need be with a modulus of 0.
  [[nodiscard]] Expected<void> set_bending(std::size_t index, std::span<const Triangle> triangles, std::span<const Vec3> flat,
                                           double modulus);
  // mass: kg, > 0. A uniform mass becomes one number for each particle; an error unless the plan knows the number of particles,
  // as it does if something joins them or a value is given for each.
  [[nodiscard]] Expected<void> set_mass(std::size_t particle, double mass);
  // fix() holds a particle where the state has it, from the next step on; release() lets it go with the state's velocity. A
  // plan that does not know the number of particles takes any index, also one that a state does not have.
  [[nodiscard]] Expected<void> fix(std::size_t particle);
  [[nodiscard]] Expected<void> release(std::size_t particle);
  // Tears the springs by which networks[index] joins two particles, for good: scene() lists the pair in `broken`.
  [[nodiscard]] Expected<void> break_spring(std::size_t index, const Pair& ends);
  [[nodiscard]] Expected<void> break_springs(std::size_t index, std::span<const Pair> ends);  // all of them, or none
  // Tears every spring of networks[index] that in this state is longer than `stretch` (finite, > 1) times its rest length, and
  // returns how many. A spring without rest length never tears, nor one whose length is NaN.
  [[nodiscard]] Expected<std::size_t> tear(std::size_t index, double stretch, const State<T>& state);
  // Returns the springs that tear() would tear: the lesser number of a spring's ends first, ascending.
  [[nodiscard]] Expected<std::vector<Pair>> too_long(std::size_t index, double stretch, const State<T>& state) const;

  [[nodiscard]] const Scene& scene() const noexcept;
  [[nodiscard]] double step_size() const noexcept;                    // s
  [[nodiscard]] std::optional<double> longest_step() const noexcept;  // s, if steps vary: Options::longest_step
  [[nodiscard]] Isa isa() const noexcept;
  [[nodiscard]] Arithmetic arithmetic() const noexcept;
  [[nodiscard]] Rounding rounding() const noexcept;
  [[nodiscard]] std::size_t block() const noexcept;  // particles
  // The limit of a scene with networks, constraints, skins, meet or followers of a motion; none for other scenes.
  [[nodiscard]] std::optional<NetworkLimit> network_limit() const;
  // Describes the scene's needs in words: passes, combined forces, bytes and operations per particle-step, instabilities.
  [[nodiscard]] std::string explain() const;

 private:
  friend struct ReportedStep<T>;
  friend class Instance<T>;
  Parts* parts_;  // owned; <memory> would cost each file that includes this a tenth of a second
};

// Compiles a scene in which all particles are alike: no values each, no anchors at the start.
template <class T>
[[nodiscard]] DVDX_EXPORT Expected<Plan<T>> compile(const Scene& scene, const Options& options);

// Compiles a scene for the particles of a state. Takes their count, and their positions for anchors and lengths at the start.
template <class T>
[[nodiscard]] DVDX_EXPORT Expected<Plan<T>> compile(const Scene& scene, const Options& options, const State<T>& start);

extern template class Workspace<float>;
extern template class Workspace<double>;
extern template class Plan<float>;
extern template class Plan<double>;

}  // namespace dvdx
