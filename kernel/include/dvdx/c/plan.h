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
  DVDX_ISA_BEST = 0,  // the one that the environment variable DVDX_ISA names, else the best of this machine
  DVDX_ISA_REFERENCE,
  DVDX_ISA_SSE2,
  DVDX_ISA_AVX2,
  DVDX_ISA_AVX512,
  DVDX_ISA_NEON64,
} dvdx_isa;

typedef enum dvdx_arithmetic {
  DVDX_SEPARATE = 0,  // multiply, then add: the same bits on every instruction set
  DVDX_CONTRACTED,    // fused multiply-add
  DVDX_FAST,          // contracted, with estimated inverse roots: bits may differ between machines; see Arithmetic in isa.hpp
} dvdx_arithmetic;

// Allocator of a plan's handle and columns: the memory with a number for each particle, spring or constraint that a step reads
// or works in. The copy of the scene and its lists come from the C++ library's operator new. It is called while a plan is made,
// changed or destroyed, never by a step, and on the calling thread.
typedef struct dvdx_allocator {
  // Returns memory aligned to `alignment` bytes, a power of two, or null if there is none.
  void* (*allocate)(void* context, size_t bytes, size_t alignment);              // null: the C++ library's
  void (*release)(void* context, void* memory, size_t bytes, size_t alignment);  // not null if allocate is not null
  void* context;  // must live as long as the plan, its clones and its workspaces
} dvdx_allocator;

typedef enum dvdx_rounding {
  DVDX_PLAIN = 0,
  DVDX_COMPENSATED,  // for float32 alone: the residual columns x_rest and v_rest keep the digits that do not fit
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
  double frequency;      // rad/s: the highest of the springs in their start position
  double bound;          // rad/s: no position has a higher frequency
  double limit;          // frequency times sub-step that the scheme allows; infinite for sequential
  int fewest;            // sub-steps below which no plan is made
  int safe;              // sub-steps that are stable in any position
  uint32_t particle;     // the one whose springs set the bound
  double damping;        // 1/s: no position has a higher rate of damping along the springs
  double damping_limit;  // that rate times sub-step that the scheme allows; infinite for sequential
  dvdx_scheme scheme;    // by which the plan steps
  double side;           // m, for sequential: side of the net with the worst estimate; 0 if nothing hangs
  double rest_error;     // m: by how much that net hangs too low
  double motion_error;   // m: error of that net in a swing
  // s: upper limit of a sub-step if sequential chooses their number; else 0. It is chosen when the plan is made, and changes
  // keep it; a plan made of the changed scene has the same bits if its coupling names this value.
  double longest_substep;
} dvdx_network_limit;

// Makes a plan for the scene as it is now; the scene may be destroyed after it. start: the particles. The plan takes their
// count and positions if the scene has values for each or joins particles; null if it has none of these.
DVDX_EXPORT dvdx_status dvdx_plan_create(const dvdx_scene* scene, const dvdx_options* options, const dvdx_state* start,
                                         dvdx_plan** plan, dvdx_error* error);
// Makes a plan for another state of the same scene. It shares the compiled scene and has working memory of its own, so that
// another thread may step it. A later change of one does not change the other.
DVDX_EXPORT dvdx_status dvdx_plan_clone(const dvdx_plan* plan, dvdx_plan** clone, dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_plan_destroy(dvdx_plan* plan);
// Makes a copy of the scene that the plan steps, with all changes since; destroy it by dvdx_scene_destroy().
DVDX_EXPORT dvdx_status dvdx_plan_scene(const dvdx_plan* plan, dvdx_scene** scene, dvdx_error* error);

// Moves every particle by `steps` steps, and the state's clock with them. Allocates nothing, locks nothing, and leaves the
// caller's floating-point environment as it was. parallel: null, or the caller's threads. Several threads may step different
// states with one plan. If the plan needs a workspace (below), each thread takes one of its own, or a clone.
DVDX_EXPORT dvdx_status dvdx_plan_step(const dvdx_plan* plan, dvdx_state* state, size_t steps, const dvdx_parallel* parallel,
                                       dvdx_error* error);

// The sums of one contact over all particles and all steps so far: see contact_report.hpp. They depend on neither instruction
// set, threads nor layout.
typedef struct dvdx_contact_sum {
  uint64_t hits;             // impacts
  double impulse[3];         // N s, on the surface: by impacts and by resting contact
  double torque_impulse[3];  // N m s, about the moved center of its motion, else about its own center or the origin
} dvdx_contact_sum;

// An impact. Resting on a surface makes none.
typedef struct dvdx_contact_event {
  uint64_t step;  // the report's step at whose end the particle has bounced: the first is 1
  double time;    // s, of the scene
  size_t particle;
  size_t contact;
  double x[3];        // m, the place in the world
  double n[3];        // the surface's normal there, of length 1
  double impulse[3];  // N s, on the surface
} dvdx_contact_event;

typedef struct dvdx_contact_report dvdx_contact_report;

// Makes a report for a scene with this number of contacts. Events go to `room`, memory of the caller's for `capacity` of them;
// further events are only counted. Null and 0: none are kept.
DVDX_EXPORT dvdx_status dvdx_contact_report_create(size_t contacts, dvdx_contact_event* room, size_t capacity,
                                                   dvdx_contact_report** report, dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_contact_report_destroy(dvdx_contact_report* report);
DVDX_EXPORT dvdx_status dvdx_contact_report_sum(const dvdx_contact_report* report, size_t contact, dvdx_contact_sum* sum,
                                                dvdx_error* error);
// Return the number of events in the room, in the order of step, particle, time; and the number of events without room.
DVDX_EXPORT size_t dvdx_contact_report_events(const dvdx_contact_report* report);
DVDX_EXPORT uint64_t dvdx_contact_report_lost(const dvdx_contact_report* report);
// Drop all events; the second one also sets all sums to 0.
DVDX_EXPORT void dvdx_contact_report_clear_events(dvdx_contact_report* report);
DVDX_EXPORT void dvdx_contact_report_clear(dvdx_contact_report* report);

// Steps as dvdx_plan_step(), with the same bits, and reports. Particles that touch a surface are resolved one by one meanwhile.
DVDX_EXPORT dvdx_status dvdx_plan_step_and_report(const dvdx_plan* plan, dvdx_state* state, size_t steps,
                                                  const dvdx_parallel* parallel, dvdx_contact_report* report,
                                                  dvdx_error* error);

// Working memory of one state while a plan steps it. It is empty for a scene without networks, constraints, skins, kinematic
// particles, particles that meet and contacts that follow a motion. One workspace may serve many states, one after the other. A
// state should have one of its own if steps carry on data in it: see Workspace in plan.hpp.
typedef struct dvdx_workspace dvdx_workspace;

// Makes a workspace for dvdx_plan_step_in() with this plan and its clones; the plan may be destroyed before it.
DVDX_EXPORT dvdx_status dvdx_workspace_create(const dvdx_plan* plan, dvdx_workspace** workspace, dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_workspace_destroy(dvdx_workspace* workspace);
// Returns the bytes that a workspace holds, without the handle; 0 for a null pointer.
DVDX_EXPORT size_t dvdx_workspace_bytes(const dvdx_workspace* workspace);

// Steps as dvdx_plan_step(), or as dvdx_plan_step_and_report() if report is not null, in this workspace. One plan steps any
// number of states on any number of threads, each in a workspace of its own. The bits do not depend on the workspace, except
// through the things that it carries on. DVDX_WORKSPACE_DIFFERS if a change since it was made needs another.
DVDX_EXPORT dvdx_status dvdx_plan_step_in(const dvdx_plan* plan, dvdx_workspace* workspace, dvdx_state* state, size_t steps,
                                          const dvdx_parallel* parallel, dvdx_contact_report* report, dvdx_error* error);

// The same motion by powers of the step's matrix. Only for scenes without networks, constraints, contacts, radial springs,
// skins, meet, fixed and kinematic particles; else DVDX_INVALID, and the error names the obstacle.
DVDX_EXPORT dvdx_status dvdx_plan_seek(const dvdx_plan* plan, dvdx_state* state, uint64_t steps, dvdx_error* error);

// Drops the history of springs and contacts that steps carry on. Call it after a jump of the state, as by a teleport of some of
// its particles. It is not needed for another state or clock, nor if all particles are moved alike or kicked. A null pointer is
// fine. Not while another thread steps with this plan.
DVDX_EXPORT void dvdx_plan_forget(dvdx_plan* plan);
DVDX_EXPORT void dvdx_workspace_forget(dvdx_workspace* workspace);  // the same for a state that is stepped in it

// Gives all data that the next step depends on besides the state's columns and clock: the history that steps carry on, and the
// targets of driven things. With them a stored state goes on with the same bits in another plan of the same scene, made for the
// same start. Not while another thread steps with this plan.
// Writes at most `capacity` numbers; *count gets the whole number of them. numbers may be null if capacity is 0.
DVDX_EXPORT dvdx_status dvdx_plan_carried(const dvdx_plan* plan, const dvdx_state* state, double* numbers, size_t capacity,
                                          size_t* count, dvdx_error* error);
// Takes these numbers back; the state must be as it was then. Changes nothing if it fails.
DVDX_EXPORT dvdx_status dvdx_plan_restore(dvdx_plan* plan, const double* numbers, size_t count, const dvdx_state* state,
                                          dvdx_error* error);
// Likewise for a state that is stepped in a workspace.
DVDX_EXPORT dvdx_status dvdx_plan_carried_in(const dvdx_plan* plan, const dvdx_workspace* workspace, const dvdx_state* state,
                                             double* numbers, size_t capacity, size_t* count, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_restore_in(const dvdx_plan* plan, dvdx_workspace* workspace, const double* numbers,
                                             size_t count, const dvdx_state* state, dvdx_error* error);

// "Be there at the end of the next step". The followers of a motion, or the particles of a kinematic group, go there on a
// straight line (a pose also turns evenly, the short way round). In every sub-step they are on it and have its velocity. After
// the step they rest until the next target. The motion's keys no longer count. Nothing is compiled; set_places takes memory at
// its first call. Not while another thread steps with this plan.
// translation: three numbers, m; rotation: a rotation vector, rad, or null: not turned.
DVDX_EXPORT dvdx_status dvdx_plan_set_pose(dvdx_plan* plan, size_t motion, const double* translation, const double* rotation,
                                           dvdx_error* error);
// places: three numbers for each of the group's particles, m, in the world.
DVDX_EXPORT dvdx_status dvdx_plan_set_places(dvdx_plan* plan, size_t kinematic, const double* places, size_t count,
                                             dvdx_error* error);
// Likewise for a skin: points and normals, three numbers for each of its particles. If normals is null, the former ones stay.
// Takes no memory.
DVDX_EXPORT dvdx_status dvdx_plan_set_skin(dvdx_plan* plan, size_t skin, const double* points, const double* normals,
                                           size_t count, dvdx_error* error);
// Likewise for the state that is stepped in a workspace. Not while a thread steps in it.
DVDX_EXPORT dvdx_status dvdx_workspace_set_pose(dvdx_workspace* workspace, size_t motion, const double* translation,
                                                const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_workspace_set_places(dvdx_workspace* workspace, size_t kinematic, const double* places,
                                                  size_t count, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_workspace_set_skin(dvdx_workspace* workspace, size_t skin, const double* points,
                                                const double* normals, size_t count, dvdx_error* error);

// The same as a jump: the followers are there when the next step begins, nothing between is swept, and a waiting target is
// dropped. They rest in that step, unless one of the functions above is called before it: then they move on to that target. The
// program carries the state's own positions along.
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

// Carries a state elsewhere by one rigid motion of the world, x to R x + translation, with all followers of motions, all driven
// things and the history that steps carry on. No speed changes. Contacts that follow no motion, anchors and the directions of
// forces stay: see Plan::teleport in plan.hpp. translation: m; rotation: a rotation vector about the world's origin, rad, or
// null.
DVDX_EXPORT dvdx_status dvdx_plan_teleport(dvdx_plan* plan, const dvdx_state* state, const double* translation,
                                           const double* rotation, dvdx_error* error);
// Likewise for a state that is stepped in a workspace.
DVDX_EXPORT dvdx_status dvdx_plan_teleport_in(const dvdx_plan* plan, dvdx_workspace* workspace, const dvdx_state* state,
                                              const double* translation, const double* rotation, dvdx_error* error);

// The condition of a state: see StateCheck in plan.hpp.
typedef struct dvdx_state_check {
  double stretch;           // the largest ratio of a spring's length to its rest length; 0: there is none
  size_t network;           // the network of that spring
  uint32_t spring[2];       // its ends
  double off;               // the largest violation of a distance constraint, as part of its length; 0: all hold
  size_t constraint;        // its index in the scene
  uint32_t rod[2];          // its ends
  double kinetic;           // J
  double elastic;           // J, of springs between particles
  double weight;            // J, in constant forces, zero at the world's origin
  size_t not_finite;        // particles whose place or velocity is infinite or NaN
  size_t first_not_finite;  // if there are any
} dvdx_state_check;
// Makes one pass over the particles and one over springs and constraints. DVDX_COUNT_DIFFERS if the state's count is not the
// plan's.
DVDX_EXPORT dvdx_status dvdx_plan_check(const dvdx_plan* plan, const dvdx_state* state, dvdx_state_check* check,
                                        dvdx_error* error);

// How particles met in the last sub-step: see Meetings in meet.hpp.
typedef struct dvdx_meetings {
  double listed;        // pairs within reach, per particle on average
  double touching;      // pairs that touch, per particle on average
  size_t most;          // the largest number of pairs within reach of one particle
  uint64_t rebuilt;     // times that lists were built
  uint64_t substeps;    // sub-steps in the same time
  double overlap_mean;  // mean overlap of pairs that touch, as part of each pair's wanted distance
  double overlap_most;
  double stretch_limit;   // of cloth: cells stretched by less let nothing pass; 0: balls
  size_t passing_layers;  // pairs of cloth that started too near, are no neighbours along it, and never meet
} dvdx_meetings;
// Before the first step the last two fields alone are set; all are 0 if nothing meets. workspace: the state's own; null: the
// plan's.
DVDX_EXPORT dvdx_status dvdx_plan_meetings(const dvdx_plan* plan, const dvdx_workspace* workspace, dvdx_meetings* meetings,
                                           dvdx_error* error);

// Changes. Each recomputes the parts that it touches, and changes nothing if it fails. Not while another thread steps with this
// plan; clones keep their scene. Rest lengths and anchors at the start stay.
// Sets another step, s. Steps then vary: networks by `sequential` are solved for the sub-step of the step that the plan was
// compiled for, and a longer step takes more sub-steps. A step that needs more than the coupling's most_substeps is cut to the
// longest one that these keep stable: dvdx_plan_step_size() returns it.
DVDX_EXPORT dvdx_status dvdx_plan_set_step(dvdx_plan* plan, double step, dvdx_error* error);
// The plan's force, or contact, `index` becomes force, or contact, `from` of a scene. A contact cannot get a motion in a plan
// that was compiled without networks, constraints, skins, meet and followers of a motion.
DVDX_EXPORT dvdx_status dvdx_plan_replace(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                          dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_replace_contact(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                                  dvdx_error* error);
// The same, named as in C++ and Python.
DVDX_EXPORT dvdx_status dvdx_plan_set_force(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                            dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_set_contact(dvdx_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                              dvdx_error* error);
// Sets the air that networks with aerodynamics meet. Takes memory for its copy.
DVDX_EXPORT dvdx_status dvdx_plan_set_wind(dvdx_plan* plan, const dvdx_wind* wind, dvdx_error* error);
// Sets the fields of these names, of dvdx_grid or dvdx_springs, in the plan's network `index`.
DVDX_EXPORT dvdx_status dvdx_plan_set_grid_stiffness(dvdx_plan* plan, size_t index, double structural, double shear,
                                                     double bend, double damping, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_set_springs_stiffness(dvdx_plan* plan, size_t index, const dvdx_scalars* stiffness,
                                                        double damping, dvdx_error* error);
// Makes the plan's network `bending->network`, springs, bend by these angles, in place of all bending by angles before. The
// network must have the pairs that dvdx_scene_add_bending() adds, as after a call with a modulus of 0.
DVDX_EXPORT dvdx_status dvdx_plan_set_bending(dvdx_plan* plan, const dvdx_bending* bending, dvdx_error* error);
// mass: kg > 0. The plan must know the number of particles: something joins them, or a value is given for each.
DVDX_EXPORT dvdx_status dvdx_plan_set_mass(dvdx_plan* plan, size_t particle, double mass, dvdx_error* error);
// dvdx_plan_fix() holds a particle where the state has it; dvdx_plan_release() lets it go with the state's velocity.
DVDX_EXPORT dvdx_status dvdx_plan_fix(dvdx_plan* plan, size_t particle, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_plan_release(dvdx_plan* plan, size_t particle, dvdx_error* error);
// Tears the springs by which the plan's network `index` joins two particles, for good.
DVDX_EXPORT dvdx_status dvdx_plan_break_spring(dvdx_plan* plan, size_t index, uint32_t a, uint32_t b, dvdx_error* error);
// Tears every spring of the plan's network `index` that in this state is longer than `stretch` (> 1) times its rest length.
// *torn gets their number; torn may be null.
DVDX_EXPORT dvdx_status dvdx_plan_tear(dvdx_plan* plan, size_t index, double stretch, const dvdx_state* state, size_t* torn,
                                       dvdx_error* error);

// A null pointer gives a step of NaN, DVDX_ISA_BEST, DVDX_FLOAT32, no limit and no text.
DVDX_EXPORT double dvdx_plan_step_size(const dvdx_plan* plan);  // s
DVDX_EXPORT dvdx_isa dvdx_plan_isa(const dvdx_plan* plan);
DVDX_EXPORT dvdx_precision dvdx_plan_precision(const dvdx_plan* plan);
// Returns 1 and writes the limit if the scene has networks, constraints, skins, meet or followers of a motion; else returns 0.
DVDX_EXPORT int dvdx_plan_network_limit(const dvdx_plan* plan, dvdx_network_limit* limit);
// Describes the scene's needs in words: passes, forces, bytes, operations, instabilities. Writes as dvdx_build_info().
DVDX_EXPORT size_t dvdx_plan_explain(const dvdx_plan* plan, char* text, size_t capacity);

#ifdef __cplusplus
}
#endif

#endif
