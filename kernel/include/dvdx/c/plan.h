// A part of dvdx/dvdx.h: plans.
#ifndef DVDX_C_PLAN_H
#define DVDX_C_PLAN_H

#include <stddef.h>
#include <stdint.h>

#include "dvdx/c/scene.h"
#include "dvdx/export.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct dvdx_plan dvdx_plan;

typedef enum dvdx_isa {
  DVDX_ISA_BEST = 0,  // of this machine, or the one that the environment variable DVDX_ISA names
  DVDX_ISA_REFERENCE,
  DVDX_ISA_SSE2,
  DVDX_ISA_AVX2,
  DVDX_ISA_AVX512,
  DVDX_ISA_NEON64,
} dvdx_isa;

typedef enum dvdx_arithmetic {
  DVDX_SEPARATE = 0,  // multiply, then add: the same bits on every instruction set
  DVDX_CONTRACTED,    // fused multiply-add
  DVDX_FAST,          // and estimated inverse roots: the bits may differ between machines; see Arithmetic in isa.hpp
} dvdx_arithmetic;

// Where a plan's memory comes from: all columns with a number for each particle, spring or constraint, which a step reads or
// works in, and the handle. The copy of the scene and its lists come from the C++ library's operator new. Called while a plan
// is made, changed or destroyed, never by a step, and on the thread that calls.
typedef struct dvdx_allocator {
  // Memory aligned to `alignment` bytes, a power of two; null: there is none.
  void* (*allocate)(void* context, size_t bytes, size_t alignment);              // null: the C++ library's
  void (*release)(void* context, void* memory, size_t bytes, size_t alignment);  // not null where allocate is not
  void* context;  // must live as long as the plan, its clones and its workspaces
} dvdx_allocator;

typedef enum dvdx_rounding {
  DVDX_PLAIN = 0,
  DVDX_COMPENSATED,  // of float32 alone: digits that do not fit are kept in the state's residual columns, x_rest and v_rest
} dvdx_rounding;

typedef struct dvdx_options {
  double step;  // s, finite; negative runs time backwards
  dvdx_precision precision;
  dvdx_isa isa;
  dvdx_arithmetic arithmetic;
  size_t block;  // particles that stay in first-level cache together: a multiple of 16, at most 1024; 0: chosen
  dvdx_rounding rounding;
  int impacts;  // 1..1000: impacts of one particle that one step resolves; 0: 32
  dvdx_allocator allocator;
} dvdx_options;

// The caller's threads: run() calls body(task, index) for every index below count, on any threads, and returns when all are
// done. body allocates nothing and throws nothing, and results never depend on which thread runs which index.
typedef void (*dvdx_body)(void* task, size_t index);
typedef struct dvdx_parallel {
  void (*run)(void* context, size_t count, dvdx_body body, void* task);
  void* context;
} dvdx_parallel;

// The limit of the sub-steps of a scene's networks: see NetworkLimit in plan.hpp.
typedef struct dvdx_network_limit {
  int substeps;          // a step, chosen or asked for
  double frequency;      // rad/s: the highest of the springs as they stand at the start
  double bound;          // rad/s: no position has a higher one
  double limit;          // frequency times sub-step that the scheme takes; infinite for sequential
  int fewest;            // sub-steps below which no plan is made
  int safe;              // sub-steps that are stable in any position
  uint32_t particle;     // whose springs set the bound
  double damping;        // 1/s: no position has a higher rate of damping along the springs
  double damping_limit;  // that rate times sub-step that the scheme takes; infinite for sequential
  dvdx_scheme scheme;    // that the plan steps by
  double side;           // m, of sequential: of the net that is estimated to be worst off; 0 where nothing hangs
  double rest_error;     // m: how much too low it hangs
  double motion_error;   // m: how far it is off in a swing
  // s, of sequential that chooses its sub-steps: none is longer. It was chosen when the plan was made, and changes keep it; a
  // plan of the changed scene has the same bits where its coupling names it. 0 for others.
  double longest_substep;
} dvdx_network_limit;

// A plan for the scene as it is now; the scene may be destroyed after it. start: the particles, whose count and places the plan
// takes where the scene has values for each or joins particles; null where it has none of these.
DVDX_EXPORT dvdx_status dvdx_plan_create(const dvdx_scene* scene, const dvdx_options* options, const dvdx_state* start,
                                         dvdx_plan** plan, dvdx_error* error);
// A plan for another state of the same scene: nothing is compiled again, and what was compiled is shared. It has working memory
// of its own, so that each may be stepped by another thread. A later change of one does not change the other.
DVDX_EXPORT dvdx_status dvdx_plan_clone(const dvdx_plan* plan, dvdx_plan** clone, dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_plan_destroy(dvdx_plan* plan);
// A copy of the scene that the plan steps, with what was changed since: to be destroyed by dvdx_scene_destroy().
DVDX_EXPORT dvdx_status dvdx_plan_scene(const dvdx_plan* plan, dvdx_scene** scene, dvdx_error* error);

// Moves every particle by `steps` steps, and the state's clock with them. Allocates nothing, locks nothing, and leaves the
// caller's floating-point environment as it was. parallel: null, or the caller's threads. Several threads may step different
// states with one plan, but for plans that need a workspace (below), of which each thread takes one, or a clone.
DVDX_EXPORT dvdx_status dvdx_plan_step(const dvdx_plan* plan, dvdx_state* state, size_t steps, const dvdx_parallel* parallel,
                                       dvdx_error* error);

// The effect of a scene's contacts on its particles: see contact_report.hpp. The sums are of one contact, over all particles
// and all steps so far: they depend on neither instruction set, threads nor layout.
typedef struct dvdx_contact_sum {
  uint64_t hits;             // impacts
  double impulse[3];         // N s, on the surface: of impacts, and of what rests on it
  double torque_impulse[3];  // N m s, about the moved center of its motion, else about its own center or the origin
} dvdx_contact_sum;

// An impact. Resting on a surface makes none.
typedef struct dvdx_contact_event {
  uint64_t step;  // of the report's, at whose end the particle has bounced: the first is 1
  double time;    // s, of the scene
  size_t particle;
  size_t contact;
  double x[3];        // m, where, in the world
  double n[3];        // the surface's normal there, of length 1
  double impulse[3];  // N s, on the surface
} dvdx_contact_event;

typedef struct dvdx_contact_report dvdx_contact_report;

// For a scene of so many contacts. Events go to `room`, memory of the caller's for `capacity` of them; what does not fit there
// is counted. Null and 0: none are kept.
DVDX_EXPORT dvdx_status dvdx_contact_report_create(size_t contacts, dvdx_contact_event* room, size_t capacity,
                                                   dvdx_contact_report** report, dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_contact_report_destroy(dvdx_contact_report* report);
DVDX_EXPORT dvdx_status dvdx_contact_report_sum(const dvdx_contact_report* report, size_t contact, dvdx_contact_sum* sum,
                                                dvdx_error* error);
// Events that stand in the room, in the order of step, particle, time; and those that found none.
DVDX_EXPORT size_t dvdx_contact_report_events(const dvdx_contact_report* report);
DVDX_EXPORT uint64_t dvdx_contact_report_lost(const dvdx_contact_report* report);
// From now on there are no events; and all sums are 0, too.
DVDX_EXPORT void dvdx_contact_report_clear_events(dvdx_contact_report* report);
DVDX_EXPORT void dvdx_contact_report_clear(dvdx_contact_report* report);

// As dvdx_plan_step(), with the same bits, and reports. Meanwhile particles that touch a surface are resolved one by one.
DVDX_EXPORT dvdx_status dvdx_plan_step_and_report(const dvdx_plan* plan, dvdx_state* state, size_t steps,
                                                  const dvdx_parallel* parallel, dvdx_contact_report* report,
                                                  dvdx_error* error);

// The memory that one state works in while a plan steps it: none where a scene has no networks, constraints, skins, kinematic
// particles and contacts that follow a motion. One may serve many states, one after the other. But networks by scheme
// sequential without theta carry on in it what the springs did in the last step: such a state should have one of its own.
typedef struct dvdx_workspace dvdx_workspace;

// For dvdx_plan_step_in() with this plan and its clones; the plan may be destroyed before it.
DVDX_EXPORT dvdx_status dvdx_workspace_create(const dvdx_plan* plan, dvdx_workspace** workspace, dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_workspace_destroy(dvdx_workspace* workspace);
// The bytes that a workspace holds, without the handle; 0 for a null pointer.
DVDX_EXPORT size_t dvdx_workspace_bytes(const dvdx_workspace* workspace);

// As dvdx_plan_step(), or where report is not null as dvdx_plan_step_and_report(), in this workspace: one plan steps any number
// of states on any number of threads, each in its own. The bits do not depend on which one it is, but for what one carries on.
// DVDX_WORKSPACE_DIFFERS where a change since it was made needs another.
DVDX_EXPORT dvdx_status dvdx_plan_step_in(const dvdx_plan* plan, dvdx_workspace* workspace, dvdx_state* state, size_t steps,
                                          const dvdx_parallel* parallel, dvdx_contact_report* report, dvdx_error* error);

// The same motion by powers of the step's matrix: for scenes without networks, constraints, contacts, radial springs and fixed
// particles; else DVDX_INVALID names what is in the way.
DVDX_EXPORT dvdx_status dvdx_plan_seek(const dvdx_plan* plan, dvdx_state* state, uint64_t steps, dvdx_error* error);

// After a jump of the state, as by a teleport of some of its particles: networks by scheme sequential without theta do not
// carry on what their springs did in the last step. Not needed for another state or another clock, nor where all particles are
// moved alike or kicked. A null pointer is fine. Not while another thread steps with this plan.
DVDX_EXPORT void dvdx_plan_forget(dvdx_plan* plan);
DVDX_EXPORT void dvdx_workspace_forget(dvdx_workspace* workspace);  // the same of a state that is stepped in it

// Everything that the next step depends on beside the state's columns and its clock: what the springs did in the last step,
// where that is carried on (see above), and what is driven. With it a stored state goes on with the same bits in another plan
// of the same scene, made for the same start. Not while another thread steps with this plan.
// Writes at most `capacity` numbers, and says in *count how many there are: numbers may be null where capacity is 0.
DVDX_EXPORT dvdx_status dvdx_plan_carried(const dvdx_plan* plan, const dvdx_state* state, double* numbers, size_t capacity,
                                          size_t* count, dvdx_error* error);
// For the state as it was then. Changes nothing where it fails.
DVDX_EXPORT dvdx_status dvdx_plan_restore(dvdx_plan* plan, const double* numbers, size_t count, const dvdx_state* state,
                                          dvdx_error* error);
// Likewise of a state that is stepped in a workspace.
DVDX_EXPORT dvdx_status dvdx_plan_carried_in(const dvdx_plan* plan, const dvdx_workspace* workspace, const dvdx_state* state,
                                             double* numbers, size_t capacity, size_t* count, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_restore_in(const dvdx_plan* plan, dvdx_workspace* workspace, const double* numbers,
                                             size_t count, const dvdx_state* state, dvdx_error* error);

// "Be there at the end of the next step": what follows a motion, or each particle of a group of kinematic ones, is on the
// straight way there in every sub-step of it and has its velocity (a pose also turns evenly, the short way round); after it
// they rest, until the next of these, and the motion's keys count no more. Nothing is compiled; set_places takes memory at its
// first call. Not while another thread steps with this plan.
// translation: three numbers, m; rotation: a rotation vector, rad, or null: not turned.
DVDX_EXPORT dvdx_status dvdx_plan_set_pose(dvdx_plan* plan, size_t motion, const double* translation, const double* rotation,
                                           dvdx_error* error);
// places: three numbers for each of the group's particles, m, in the world.
DVDX_EXPORT dvdx_status dvdx_plan_set_places(dvdx_plan* plan, size_t kinematic, const double* places, size_t count,
                                             dvdx_error* error);
// Likewise a skin: points and normals, three numbers for each of its particles; normals may be null, and then stay what they
// were. Takes no memory.
DVDX_EXPORT dvdx_status dvdx_plan_set_skin(dvdx_plan* plan, size_t skin, const double* points, const double* normals,
                                           size_t count, dvdx_error* error);
// Likewise of the state that is stepped in a workspace. Not while a thread steps in it.
DVDX_EXPORT dvdx_status dvdx_workspace_set_pose(dvdx_workspace* workspace, size_t motion, const double* translation,
                                                const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_workspace_set_places(dvdx_workspace* workspace, size_t kinematic, const double* places,
                                                  size_t count, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_workspace_set_skin(dvdx_workspace* workspace, size_t skin, const double* points,
                                                const double* normals, size_t count, dvdx_error* error);

// As a jump: it is there when the next step begins, nothing between is swept, and a target that waited is dropped. It rests in
// that step, unless one of the functions above follows before it: then it goes from here to there. The state's own positions
// are the program's to carry along.
DVDX_EXPORT dvdx_status dvdx_plan_jump_pose(dvdx_plan* plan, size_t motion, const double* translation, const double* rotation,
                                            dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_jump_places(dvdx_plan* plan, size_t kinematic, const double* places, size_t count,
                                              dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_jump_skin(dvdx_plan* plan, size_t skin, const double* points, const double* normals,
                                            size_t count, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_workspace_jump_pose(dvdx_workspace* workspace, size_t motion, const double* translation,
                                                 const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_workspace_jump_places(dvdx_workspace* workspace, size_t kinematic, const double* places,
                                                   size_t count, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_workspace_jump_skin(dvdx_workspace* workspace, size_t skin, const double* points,
                                                 const double* normals, size_t count, dvdx_error* error);

// Carries a state elsewhere by one rigid motion of the world, x to R x + translation, with all that follows motions or is
// driven and all that steps carry on: nothing has another speed than before. Contacts that follow no motion, anchors and the
// directions of forces stay: see Plan::teleport in plan.hpp. translation: m; rotation: a rotation vector about the world's
// origin, rad, or null.
DVDX_EXPORT dvdx_status dvdx_plan_teleport(dvdx_plan* plan, const dvdx_state* state, const double* translation,
                                           const double* rotation, dvdx_error* error);
// Likewise of a state that is stepped in a workspace.
DVDX_EXPORT dvdx_status dvdx_plan_teleport_in(const dvdx_plan* plan, dvdx_workspace* workspace, const dvdx_state* state,
                                              const double* translation, const double* rotation, dvdx_error* error);

// How a state stands: see StateCheck in plan.hpp.
typedef struct dvdx_state_check {
  double stretch;           // of the spring that is longest of its rest length: length by rest length; 0: there is none
  size_t network;           // whose it is
  uint32_t spring[2];       // its ends
  double off;               // of the distance constraint that is farthest off, as part of its length; 0: none is
  size_t constraint;        // which of the scene's
  uint32_t rod[2];          // its ends
  double kinetic;           // J
  double elastic;           // J, of springs between particles
  double weight;            // J, in constant forces, from the world's origin on
  size_t not_finite;        // particles whose place or velocity is infinite or not a number
  size_t first_not_finite;  // where there are any
} dvdx_state_check;
// One pass over the particles and one over what joins them. DVDX_COUNT_DIFFERS where the state is not of as many particles as
// the plan.
DVDX_EXPORT dvdx_status dvdx_plan_check(const dvdx_plan* plan, const dvdx_state* state, dvdx_state_check* check,
                                        dvdx_error* error);

// How particles met in the last sub-step: see Meetings in meet.hpp.
typedef struct dvdx_meetings {
  double listed;        // pairs within reach, of each particle on average
  double touching;      // pairs that touch, of each particle on average
  size_t most;          // pairs within reach of the particle that has most
  uint64_t rebuilt;     // how often lists were built
  uint64_t substeps;    // meanwhile
  double overlap_mean;  // of pairs that touch, as part of the distance that each pair wants
  double overlap_most;
  double stretch_limit;   // of cloth: springs stretched by less let nothing pass; 0: balls
  size_t passing_layers;  // pairs of cloth that started too near, are no neighbours along it, and never meet
} dvdx_meetings;
// Before the first step the last two alone; all 0 where nothing meets. workspace: the state's own; null: the plan's.
DVDX_EXPORT dvdx_status dvdx_plan_meetings(const dvdx_plan* plan, const dvdx_workspace* workspace, dvdx_meetings* meetings,
                                           dvdx_error* error);

// Changes. Each makes again what it touches, and changes nothing where it fails. Not while another thread steps with this plan;
// clones keep what they had. Rest lengths and anchors at the start stay what they were.
// Another step, in s. Steps then vary: networks by `sequential` keep the sub-steps of the step that the plan was compiled for,
// and a longer step takes more of them. One that would take more than the coupling's most_substeps is cut to the longest step
// that these keep stable: dvdx_plan_step_size() says which.
DVDX_EXPORT dvdx_status dvdx_plan_set_step(dvdx_plan* plan, double step, dvdx_error* error);
// The plan's force, or contact, `index` becomes force, or contact, `from` of a scene. In a plan that was compiled without
// networks, constraints, skins and followers of a motion a contact takes no motion.
DVDX_EXPORT dvdx_status dvdx_plan_replace(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                          dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_replace_contact(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                                  dvdx_error* error);
// The same by the names that C++ and Python have.
DVDX_EXPORT dvdx_status dvdx_plan_set_force(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                            dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_set_contact(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                              dvdx_error* error);
// The air that networks with aerodynamics meet. Takes memory for what it copies.
DVDX_EXPORT dvdx_status dvdx_plan_set_wind(dvdx_plan* plan, const dvdx_wind* wind, dvdx_error* error);
// Sets the plan's network `index`, a grid or springs: the fields of dvdx_grid or dvdx_springs that bear these names.
DVDX_EXPORT dvdx_status dvdx_plan_set_grid_stiffness(dvdx_plan* plan, size_t index, double structural, double shear,
                                                     double bend, double damping, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_set_springs_stiffness(dvdx_plan* plan, size_t index, const dvdx_scalars* stiffness,
                                                        double damping, dvdx_error* error);
// Makes the plan's network `bending->network`, springs, bend by these angles in place of all that it did before. Its pairs must
// hold those that dvdx_scene_add_bending() adds, as after one with a modulus of 0.
DVDX_EXPORT dvdx_status dvdx_plan_set_bending(dvdx_plan* plan, const dvdx_bending* bending, dvdx_error* error);
// kg > 0. The plan must know how many particles there are: where something joins them, or a value is given for each.
DVDX_EXPORT dvdx_status dvdx_plan_set_mass(dvdx_plan* plan, size_t particle, double mass, dvdx_error* error);
// Holds a particle where the state has it; lets it go with the velocity that the state has.
DVDX_EXPORT dvdx_status dvdx_plan_fix(dvdx_plan* plan, size_t particle, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_release(dvdx_plan* plan, size_t particle, dvdx_error* error);
// Tears what the plan's network `index` joins two particles by, for good.
DVDX_EXPORT dvdx_status dvdx_plan_break_spring(dvdx_plan* plan, size_t index, uint32_t a, uint32_t b, dvdx_error* error);
// Tears every spring of the plan's network `index` that in this state is longer than `stretch` (> 1) times its rest length;
// says in *torn (which may be null) how many those were.
DVDX_EXPORT dvdx_status dvdx_plan_tear(dvdx_plan* plan, size_t index, double stretch, const dvdx_state* state, size_t* torn,
                                       dvdx_error* error);

// A null pointer gives a step that is not a number, DVDX_ISA_BEST, DVDX_FLOAT32, no limit and no text.
DVDX_EXPORT double dvdx_plan_step_size(const dvdx_plan* plan);  // s
DVDX_EXPORT dvdx_isa dvdx_plan_isa(const dvdx_plan* plan);
DVDX_EXPORT dvdx_precision dvdx_plan_precision(const dvdx_plan* plan);
// 1, and the limit, where the scene has networks or constraints; else 0.
DVDX_EXPORT int dvdx_plan_network_limit(const dvdx_plan* plan, dvdx_network_limit* limit);
// The scene's needs, in words: passes, forces, bytes, operations, what is unstable. As dvdx_build_info().
DVDX_EXPORT size_t dvdx_plan_explain(const dvdx_plan* plan, char* text, size_t capacity);

#ifdef __cplusplus
}
#endif

#endif
