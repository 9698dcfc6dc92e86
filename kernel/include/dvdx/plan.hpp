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

// An error in a scene, an option or a state: the field ("forces[2].stiffness"), its value, and what is valid.
struct Error {
  std::string field;
  std::string value;
  std::string valid;
  [[nodiscard]] DVDX_EXPORT std::string message() const;
};

template <class T>
using Expected = tl::expected<T, Error>;

// The fate of the digits of a step's result that the state's scalar type cannot hold.
enum class Rounding {
  plain,  // they are lost
  // They are carried in the state's residual columns, and the step is worked out in float64: of float32 states alone. The
  // numbers are those of a float64 step to 48 bits; x and v stay readable float32 columns. Costs a float64 step and, once
  // a call, the conversion to float64 and back (bench/compensated_bench.cpp). Kahan's sums in float32 lanes would cost less
  // where a call is one step, and leave the coefficients' rounding, which grows faster than the state's (docs/precision.md).
  compensated,
};

// The fate of springs between particles that are asked to be stepped in fewer sub-steps than they need to be stable.
enum class Unstable {
  refused,  // compile() and set_step() name the fewest
  allowed,  // they are stepped, and may grow without bound: for studies of instability
};

struct Options {
  double step = 1.0 / 60;  // s, finite; negative runs time backwards, and a step of 0 changes no bit
  // s, finite and > 0: steps vary, as frames do. Springs by `sequential` then have the sub-steps of this step: a longer one
  // takes more of them, and a shorter one is as exact as this one, not more so. None: all steps are alike, until set_step()
  // gives one of another length; from then on it is the length that the plan was compiled for. A plan for frames that vary is
  // compiled for the usual frame, one whose step is another for good is compiled anew.
  std::optional<double> longest_step{};
  std::optional<Isa> isa{};  // the best where none is asked for
  Arithmetic arithmetic = Arithmetic::separate;
  std::size_t block = 0;  // particles that stay in first-level cache together: a multiple of 16, at most 1024; 0: chosen
  Rounding rounding = Rounding::plain;
  int impacts = 32;  // 1..1000: impacts of one particle that one step resolves in time order; what is left is clamped
  Unstable unstable = Unstable::refused;
  // Where the plan's columns come from: what holds a number for each particle, spring or constraint and is read or worked in by
  // a step. The scene's copy and its lists come from operator new. Where either has none left, std::bad_alloc is thrown.
  Memory memory{};
  PartContext elsewhere{};  // of a state that is stepped in parts
};

// An attribute of an enumeration is beyond the formatter:
// clang-format off
enum class [[nodiscard]] StepResult {
  done,
  count_differs,       // the plan holds values per particle, and the state has another count: nothing was stepped
  capacity_too_small,  // a column's capacity is below the state's count, or it has no memory (a compensated plan: its residuals'
                       // too): nothing was stepped
  in_use,              // another thread steps with this plan's own workspace, or with the one given: nothing was stepped
  workspace_differs,   // the workspace given is moved from, or was made for another scene: other particles, another scheme, other
                       // things that join or are driven. Other steps and sub-steps, and other numbers, it fits. Nothing was
                       // stepped
  report_differs,      // the report given is for another number of contacts: nothing was stepped
  time_not_finite,     // the state's clock is infinite or not a number: nothing was stepped
  // The plan has been told, by set_pose and its like, where something goes, and the workspace given neither then nor since:
  // nothing was stepped. Tell the workspace, or have an Instance of the state (dvdx/instance.hpp).
  driven_elsewhere,
  moved_from,          // the plan, or the instance, was moved from: there is nothing to step by
  // More particles came within reach of one than Meet::most_neighbours. The state is that of the call's start, its clock too.
  // Motions, groups and skins that are driven have gone to their targets; nothing is carried on, as after forget().
  too_many_neighbours,
};
// clang-format on

// How far a net that sweeps step is estimated to be off, of the one that is worst off: sweeps leave springs softer than they
// are. Made of its springs, masses, of what is held and of the scene's constant accelerations; all 0 where nothing hangs on
// what is held.
struct SweepEstimate {
  double side = 0;    // m: from what holds it to what is farthest, along the springs at rest
  double sag = 0;     // m: how far exact springs would stretch under the load
  double rest = 0;    // m: how much too low it hangs
  double motion = 0;  // m: how far a swing is off
  // Frequency with which a net's springs turn under their load, times the sub-step, where lines are solved. Beyond most_turning
  // a sheet that falls into place may not come to rest, but swing on at some tenths of a m/s.
  double turning = 0;
  double most_turning = 0;
};

// Which scheme `automatic` became: sub-steps a step that each takes, and ns a step by the table of costs.
struct SchemeChoice {
  Scheme scheme = Scheme::leapfrog;
  int leapfrog = 1, sequential = 1;
  double leapfrog_cost = 0, sequential_cost = 0;
};

// The limit of the sub-steps of a scene's networks.
struct NetworkLimit {
  int substeps = 1;            // a step, chosen or asked for
  double frequency = 0;        // rad/s: the highest of the springs as they stand at the start, by Lanczos' iteration
  double bound = 0;            // rad/s: no position of the particles has a higher one
  double limit = 0;            // frequency times sub-step that the scheme takes; infinite for sequential
  int fewest = 1;              // sub-steps a step below which compile() refuses: of a grid without contacts, where the start's
                               // frequency and 7 % more are unstable; else `safe`
  int safe = 1;                // sub-steps a step that are stable in any position. "auto" takes the fewest with which also
                               // the energy of linear springs stays within half and twice of what it was
  std::uint32_t particle = 0;  // whose springs set the bound
  double damping = 0;          // 1/s: no position of the particles has a higher rate of damping along the springs
  double damping_limit = 0;    // that rate times sub-step that the scheme takes; infinite for sequential
  double rho = 0;              // of sequential's generalized alpha: which part of a stiff motion a sub-step leaves
  Scheme scheme = Scheme::leapfrog;      // that the plan steps by
  SweepEstimate estimate{};              // of sequential
  std::optional<SchemeChoice> choice{};  // where the scene left the scheme open
};

// How a state stands: Plan::check().
struct StateCheck {
  // count_differs and capacity_too_small as a step has them: nothing was looked at. Else done.
  StepResult result = StepResult::done;
  // The length of the whole spring that is longest of its rest length, as part of that. Springs without stiffness or without
  // rest length do not count, nor do those whose length is not a number. 0: there is none.
  double stretch = 0;
  std::size_t network = 0;  // whose it is
  Pair spring{};            // its ends, the lesser number first
  // How far the Distance constraint that is worst is off what it is bound to, as part of its length. 0: none is off.
  double off = 0;
  std::size_t constraint = 0;
  Pair rod{};
  // J, of particles that are neither fixed nor kinematic, of whole springs, and of these particles in all constant forces, from
  // the world's origin on. Not in it: springs to anchors, drag, and forces that depend on time. Each is not a number where that
  // of a particle in it is none.
  double kinetic = 0, elastic = 0, weight = 0;
  std::size_t not_finite = 0;        // particles whose place or velocity is infinite or not a number, fixed ones too
  std::size_t first_not_finite = 0;  // where there are any
};

template <class T>
class Plan;
template <class T>
class Instance;  // dvdx/instance.hpp
template <class T>
struct ReportedStep;  // private to the library

// The memory that one state works in while a plan steps it: empty where a scene has no networks, constraints, skins, kinematic
// particles, particles that meet and contacts that follow a motion. One may serve many states, one after the other. But
// networks by scheme sequential without theta carry on what the springs did in the last step, and particles that meet the
// pulses of their contacts. Both stand here: where the state's columns and clock are not those that the last step left, the
// next one starts without, by a sub-step of first order. Such a state should have a workspace, or a plan, of its own.
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
  // By what add_body() and its like have returned; likewise below.
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

// T is float or double. A plan is a compiled scene, which its clones share, and a workspace of its own. Any number of threads
// may step different states with it at once, each with its own clone or workspace (where Workspace is empty, neither is
// needed), none of them while a change runs.
template <class T>
class DVDX_EXPORT Plan {
 public:
  struct Parts;  // private to the library

  explicit Plan(Parts* parts) noexcept;  // which it owns from then on
  Plan(Plan&&) noexcept;
  Plan& operator=(Plan&&) noexcept;
  ~Plan();

  // The same compiled scene with a workspace of its own, for another state: nothing is compiled again. A later change of one
  // does not change the other. Throws std::bad_alloc where there is no memory.
  [[nodiscard]] Plan clone() const;
  // Working memory for step() below, in which everything driven is where this plan has it; likewise.
  [[nodiscard]] Workspace<T> workspace() const;
  // A state with all that belongs to it: a workspace, what drives it, its own wind and frame time. Include dvdx/instance.hpp.
  // An error where a step would refuse the state. Throws std::bad_alloc.
  [[nodiscard]] Expected<Instance<T>> instance(const State<T>& state) const;

  // Moves every particle by `steps` steps, all of them while its block is in cache, and the state's clock with them. A call of
  // no steps puts kinematic particles where their motions have them at the state's time. Allocates nothing, throws nothing,
  // locks nothing. Denormals are flushed to zero meanwhile, and the caller's floating-point environment is restored.
  StepResult step(State<T>& state, std::size_t steps = 1, const ParallelFor& parallel = {}) const noexcept;
  // The same in a workspace of the caller's, made by this plan or a clone: workspace_differs where a change since then needs
  // another; driven_elsewhere where set_pose and its like told this plan, and not that workspace, where something goes. The
  // bits do not depend on which workspace it is, but for what one carries on.
  StepResult step(State<T>& state, Workspace<T>& workspace, std::size_t steps = 1,
                  const ParallelFor& parallel = {}) const noexcept;
  // The same, and reports what the scene's contacts do. The bits are those of a step without: what touches a surface is then
  // resolved particle by particle, and all else as fast as ever.
  StepResult step(State<T>& state, ContactReport& contacts, std::size_t steps = 1,
                  const ParallelFor& parallel = {}) const noexcept;
  StepResult step(State<T>& state, Workspace<T>& workspace, ContactReport& contacts, std::size_t steps = 1,
                  const ParallelFor& parallel = {}) const noexcept;

  // After a jump of the state, as by a teleport of some of its particles: what its springs did before is not carried on. Not
  // needed for another state or another clock, nor where all particles are moved alike, kicked, or stepped with another step.
  void forget() noexcept;

  // Everything that the next step depends on beside the state's columns and its clock: what springs, and particles that meet,
  // did in the last step, where that is carried on (see Workspace), and what is driven by set_pose and set_places. With it a
  // stored state goes on elsewhere with the same bits: in a plan of the same scene, compiled for the same start, on any
  // instruction set. The numbers are for restore() alone, few or none where there is nothing to keep. Not while another thread
  // steps with this plan, or in this workspace.
  [[nodiscard]] std::vector<double> carried(const State<T>& state) const;
  [[nodiscard]] std::vector<double> carried(const State<T>& state, const Workspace<T>& workspace) const;
  // For the state as it was then: count, columns and clock. Changes nothing where it fails.
  [[nodiscard]] Expected<void> restore(std::span<const double> carried, const State<T>& state);
  [[nodiscard]] Expected<void> restore(std::span<const double> carried, const State<T>& state, Workspace<T>& workspace) const;

  // The same motion `steps` steps ahead by powers of the step's matrix. Only for scenes without networks, constraints,
  // contacts, radial springs, skins, fixed and kinematic particles; an error names what is in the way.
  [[nodiscard]] Expected<void> seek(State<T>& state, std::uint64_t steps) const;

  // "Be there at the end of the next step", whichever call makes it. In every sub-step of it what follows motions[motion], or
  // the particles of kinematic[kinematic], are on the straight way there (a pose also turns evenly, the short way round) and
  // have its velocity; after it they rest, until the next of these. The keys of the motion count no more. Neither compiles
  // anything; set_places takes memory at its first call. Both drive the state that is stepped in the plan's own workspace;
  // workspaces that are made later start there, and a clone by the keys. Not while another thread steps with it.
  // By Arrival::jump it is there when the next step begins, and nothing between is swept; a target that waited is dropped. It
  // rests in that step, unless another target follows before it, by Arrival::moving: then it goes from here to there. So a
  // character that is carried elsewhere while it walks jumps to where it stood, carried along, and moves on from there. The
  // state's own positions are the program's to carry along.
  [[nodiscard]] Expected<void> set_pose(std::size_t motion, const Pose& target, Arrival arrival = Arrival::moving);
  // places: m, in the world, one for each particle
  [[nodiscard]] Expected<void> set_places(std::size_t kinematic, std::span<const Vec3> places,
                                          Arrival arrival = Arrival::moving);
  // Likewise skins[skin], one point and one normal for each of its particles (m, in the world; of any length > 0). Without
  // normals those of a back-stop stay what they were. Takes no memory.
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

  // Carries a state elsewhere by one rigid motion of the world, x to R x + translation (R about the world's origin): its places
  // and velocities with what springs did in the last step, fixed particles, and all that follows a motion or is driven. Keys of
  // motions go on from there; targets that wait are carried along, and later ones are of the world, as ever. Nothing has
  // another speed than before, and nothing between is swept. Places that the scene names in the world stay: contacts that
  // follow no motion, anchors of forces, those at the start too, and the directions of forces and wind. Takes no memory, but
  // for an error. An error, and nothing is changed: where `by` is not finite, or the state as a step refuses it; where a
  // constraint holds a particle on a point or a line of the world, which would draw it back; and where T rounds the new places,
  // from the scene's origin, by more than 1/64 of the shortest spring or rod. Particles at infinity stay there. Not while
  // another thread steps with this plan, or in this workspace.
  [[nodiscard]] Expected<void> teleport(State<T>& state, const Pose& by);
  [[nodiscard]] Expected<void> teleport(State<T>& state, Workspace<T>& workspace, const Pose& by) const;

  // How long springs and rods are, what energy there is, and whether all of it is finite, at any time. One pass over the
  // particles and one over what joins them; it allocates nothing, throws nothing, and any thread may make it.
  [[nodiscard]] StateCheck check(const State<T>& state) const noexcept;

  // How particles met in the last sub-step that was made in this plan's own workspace, or in that one; before the first
  // it is what the plan alone says. All 0 where the scene has no `meet`.
  [[nodiscard]] Meetings meetings() const noexcept;
  [[nodiscard]] Meetings meetings(const Workspace<T>& workspace) const noexcept;

  // Changes of the scene. Each makes again what it touches, and changes nothing where it fails: with an error, or with
  // std::bad_alloc. Not while another thread steps with this plan; clones keep what they had. The plan then steps as one
  // compiled anew from scene(), in which the scheme and the longest sub-step that it chose at first stand, and the particles
  // where the first one was compiled: rest lengths and anchors at the start stay what they were. set_step() makes steps vary
  // (Options::longest_step): it is the plan that compile() makes with step_size() and longest_step().
  // Where a step h needs more sub-steps than Coupling::most_substeps, set_step() takes the longest step of h's sign that so
  // many keep stable. step_size() then is shorter than h: so much time is left out.
  [[nodiscard]] Expected<void> set_step(double h);
  // forces[index] becomes `force`.
  [[nodiscard]] Expected<void> set_force(std::size_t index, const Force& force);
  // contacts[index] becomes `contact`: its pose and all its numbers. In a plan that was compiled without networks, constraints,
  // skins and followers of a motion it takes none.
  [[nodiscard]] Expected<void> set_contact(std::size_t index, const Contact& contact);
  // networks[index] becomes `network`, of the same kind, which joins the same particles: all its numbers. Torn springs stay
  // torn.
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
  // The air that networks with `aerodynamics` meet. Takes memory where there are more gusts than before.
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
  // The same by angles: what add_bending() makes of these (dvdx/bending.hpp) in place of all zero_length that there was. Only
  // of pairs that the network has; those that it lacks add_bending() adds before compile(), with a modulus of 0 as well.
  [[nodiscard]] Expected<void> set_bending(std::size_t index, std::span<const Triangle> triangles, std::span<const Vec3> flat,
                                           double modulus);
  // kg, > 0. Where all particles are alike so far they get a number each: the plan must know how many there are, which it does
  // where something joins them or a value is given for each.
  [[nodiscard]] Expected<void> set_mass(std::size_t particle, double mass);
  // Holds a particle where the state has it, from the next step on; lets it go, with the velocity that the state has. A plan
  // that does not know how many particles there are takes any number, also one that a state does not have.
  [[nodiscard]] Expected<void> fix(std::size_t particle);
  [[nodiscard]] Expected<void> release(std::size_t particle);
  // Tears what networks[index] joins two particles by, for good: scene() lists them as `broken`.
  [[nodiscard]] Expected<void> break_spring(std::size_t index, const Pair& ends);
  [[nodiscard]] Expected<void> break_springs(std::size_t index, std::span<const Pair> ends);  // all of them, or none
  // Tears every spring of networks[index] that in this state is longer than `stretch` (finite, > 1) times its rest length. How
  // many those were. A spring without rest length never tears, nor one whose length is not a number.
  [[nodiscard]] Expected<std::size_t> tear(std::size_t index, double stretch, const State<T>& state);
  // Those that tear() would tear: the lesser number of a spring's ends first, ascending.
  [[nodiscard]] Expected<std::vector<Pair>> too_long(std::size_t index, double stretch, const State<T>& state) const;

  [[nodiscard]] const Scene& scene() const noexcept;
  [[nodiscard]] double step_size() const noexcept;                    // s
  [[nodiscard]] std::optional<double> longest_step() const noexcept;  // s, where steps vary: Options::longest_step
  [[nodiscard]] Isa isa() const noexcept;
  [[nodiscard]] Arithmetic arithmetic() const noexcept;
  [[nodiscard]] Rounding rounding() const noexcept;
  [[nodiscard]] std::size_t block() const noexcept;  // particles
  // The limit of a scene with networks.
  [[nodiscard]] std::optional<NetworkLimit> network_limit() const;
  // The scene's needs, in words: passes, combined forces, bytes and operations per particle-step, what is unstable.
  [[nodiscard]] std::string explain() const;

 private:
  friend struct ReportedStep<T>;
  friend class Instance<T>;
  Parts* parts_;  // owned; <memory> would cost each file that includes this a tenth of a second
};

// A plan for a scene in which all particles are alike (no values each, no anchors at the start).
template <class T>
[[nodiscard]] DVDX_EXPORT Expected<Plan<T>> compile(const Scene& scene, const Options& options);

// A plan for the particles of a state: its count, and its positions where anchors stand at the start.
template <class T>
[[nodiscard]] DVDX_EXPORT Expected<Plan<T>> compile(const Scene& scene, const Options& options, const State<T>& start);

extern template class Workspace<float>;
extern template class Workspace<double>;
extern template class Plan<float>;
extern template class Plan<double>;

}  // namespace dvdx
