// A part of dvdx/dvdx.h: particles that come and go.
#ifndef DVDX_C_LIVE_H
#define DVDX_C_LIVE_H

#include <stddef.h>
#include <stdint.h>

#include "dvdx/c/plan.h"
#include "dvdx/export.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum dvdx_emit { DVDX_EMIT_POINT = 0, DVDX_EMIT_DISC, DVDX_EMIT_BOX } dvdx_emit;

// Makes particles one after another, 1/rate apart: see Emitter in turnover.hpp.
typedef struct dvdx_emitter {
  dvdx_emit shape;
  double at[3];              // m: the point, the disc's centre, or the box's least corner
  double most[3];            // m: the box's other corner, >= at
  double normal[3];          // the disc's, not zero
  double radius;             // m >= 0, the disc's
  double rate;               // particles/s >= 0
  double start;              // s: scene time at which it begins to work
  double duration;           // s > 0, the time that it works; 0: for ever
  double velocity[3];        // m/s
  double spread;             // m/s >= 0: the velocity gets a random addition, uniform in a ball of this radius
  const double* spread_box;  // or in a box of these three half sides, m/s >= 0; null: in the ball
  double least_lifetime;     // s > 0; both 0: none dies of age
  double most_lifetime;      // s >= least: lifetimes are uniform between the two
  uint64_t seed;
  size_t follows;  // 1 + the index of the scene's motion that carries its place and aim; 0: it rests
} dvdx_emitter;

// Particles are removed where normal . x < offset, for the unit normal.
typedef struct dvdx_boundary {
  double normal[3];  // not zero
  double offset;     // m
} dvdx_boundary;

typedef enum dvdx_not_finite { DVDX_NOT_FINITE_KEPT = 0, DVDX_NOT_FINITE_REMOVED } dvdx_not_finite;

// The order of the survivors after a removal. KEPT: unchanged. ANY: births and the last particles fill the holes, and nothing
// else moves. The assignment is the same for all instruction sets, threads, layouts and numbers of steps a call
// (dvdx/turnover.hpp).
typedef enum dvdx_survivor_order { DVDX_SURVIVOR_ORDER_KEPT = 0, DVDX_SURVIVOR_ORDER_ANY } dvdx_survivor_order;

// The emitters of particles, and the rules of removal besides age.
typedef struct dvdx_turnover {
  const dvdx_emitter* emitters;
  size_t emitter_count;
  const dvdx_boundary* boundaries;
  size_t boundary_count;  // at most 8
  const double* inside;   // m: particles outside of this box are removed, min x y z, max x y z; null: none
  dvdx_not_finite not_finite;
  dvdx_survivor_order order;
  size_t capacity;  // most particles that live at once, 1 to 4294967295; further births are dropped and counted
} dvdx_turnover;

// A column of the caller's own that goes along with the particles: element i lies at base + i * stride bytes. Births get zeros.
typedef struct dvdx_carried {
  void* base;
  ptrdiff_t stride;  // bytes from an element to the next
  size_t bytes;      // of an element
} dvdx_carried;

// The live particles are the first state.count. Every column must have room for the turnover's capacity.
typedef struct dvdx_live {
  dvdx_state state;
  dvdx_column age;                  // s since birth; base null: not kept
  dvdx_column lifetime;             // s; base null: none dies of age. Needs age
  const dvdx_carried* carried;      // null if carried_count is 0
  size_t carried_count;             // at most 32
  uint64_t born, removed, dropped;  // so far; dropped: births without room
} dvdx_live;

typedef struct dvdx_live_plan dvdx_live_plan;

// Makes a plan for a scene whose particles are all alike, without networks, constraints, fixed or kinematic particles and
// origin. The step must be > 0. The scene may be destroyed after it. Contacts and emitters may follow motions. Balls may meet
// if they have one radius and no groups, and survivors keep their order: see live.hpp.
DVDX_EXPORT dvdx_status dvdx_live_plan_create(const dvdx_scene* scene, const dvdx_turnover* turnover,
                                              const dvdx_options* options, dvdx_live_plan** plan, dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_live_plan_destroy(dvdx_live_plan* plan);

// Steps as dvdx_plan_step(). After each step particles that die are removed, the others keep their order (or fill the holes
// from the end: DVDX_SURVIVOR_ORDER_ANY), and the births of the step follow behind them. Steps one state at a time: a second
// thread gets DVDX_IN_USE. DVDX_TOO_MANY_NEIGHBOURS for balls that meet: `live` is as it was when the failed step began.
DVDX_EXPORT dvdx_status dvdx_live_plan_step(const dvdx_live_plan* plan, dvdx_live* live, size_t steps,
                                            const dvdx_parallel* parallel, dvdx_error* error);
// The same, and reports step by step. A particle's number is its index when its step began.
DVDX_EXPORT dvdx_status dvdx_live_plan_step_and_report(const dvdx_live_plan* plan, dvdx_live* live, size_t steps,
                                                       const dvdx_parallel* parallel, dvdx_contact_report* report,
                                                       dvdx_error* error);
// Removes the particles that the rules name in the present state, without a step. To remove a particle of your choice, make its
// age infinite.
DVDX_EXPORT dvdx_status dvdx_live_plan_remove(const dvdx_live_plan* plan, dvdx_live* live, const dvdx_parallel* parallel,
                                              dvdx_error* error);
// As dvdx_plan_teleport(), for the live particles and all followers of motions. All else stays where it is.
DVDX_EXPORT dvdx_status dvdx_live_plan_teleport(const dvdx_live_plan* plan, const dvdx_live* live, const double* translation,
                                                const double* rotation, dvdx_error* error);
// Makes a plan for another state, as dvdx_plan_clone().
DVDX_EXPORT dvdx_status dvdx_live_plan_clone(const dvdx_live_plan* plan, dvdx_live_plan** clone, dvdx_error* error);
// As dvdx_plan_set_pose(), jump_pose(), set_wind() and check().
DVDX_EXPORT dvdx_status dvdx_live_plan_set_pose(dvdx_live_plan* plan, size_t motion, const double* translation,
                                                const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_jump_pose(dvdx_live_plan* plan, size_t motion, const double* translation,
                                                 const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_set_wind(dvdx_live_plan* plan, const dvdx_wind* wind, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_check(const dvdx_live_plan* plan, const dvdx_live* live, dvdx_state_check* check,
                                             dvdx_error* error);
DVDX_EXPORT double dvdx_live_plan_step_size(const dvdx_live_plan* plan);  // s; NaN for a null pointer
// Changes: see live.hpp. The plan's force or contact `index` becomes element `from` of a scene; a contact is in place at once.
DVDX_EXPORT dvdx_status dvdx_live_plan_set_step(dvdx_live_plan* plan, double step, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_set_force(dvdx_live_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                                 dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_set_contact(dvdx_live_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                                   dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_set_emitter(dvdx_live_plan* plan, size_t index, const dvdx_emitter* emitter,
                                                   dvdx_error* error);
// Makes `births` births of emitter `index` at once.
DVDX_EXPORT dvdx_status dvdx_live_plan_burst(const dvdx_live_plan* plan, dvdx_live* live, size_t index, size_t births,
                                             dvdx_error* error);
// As dvdx_workspace: working memory of one state, with its driven motions. report may be null.
typedef struct dvdx_live_workspace dvdx_live_workspace;
DVDX_EXPORT dvdx_status dvdx_live_workspace_create(const dvdx_live_plan* plan, dvdx_live_workspace** workspace,
                                                   dvdx_error* error);
DVDX_EXPORT void dvdx_live_workspace_destroy(dvdx_live_workspace* workspace);
DVDX_EXPORT size_t dvdx_live_workspace_bytes(const dvdx_live_workspace* workspace);
DVDX_EXPORT dvdx_status dvdx_live_workspace_set_pose(dvdx_live_workspace* workspace, size_t motion, const double* translation,
                                                     const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_workspace_jump_pose(dvdx_live_workspace* workspace, size_t motion, const double* translation,
                                                      const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_step_in(const dvdx_live_plan* plan, dvdx_live_workspace* workspace, dvdx_live* live,
                                               size_t steps, const dvdx_parallel* parallel, dvdx_contact_report* report,
                                               dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_burst_in(const dvdx_live_plan* plan, dvdx_live_workspace* workspace, dvdx_live* live,
                                                size_t index, size_t births, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_teleport_in(const dvdx_live_plan* plan, dvdx_live_workspace* workspace,
                                                   const dvdx_live* live, const double* translation, const double* rotation,
                                                   dvdx_error* error);
// Describes the scene's needs, then the cost of births and removal, in words. Writes as dvdx_build_info().
DVDX_EXPORT size_t dvdx_live_plan_explain(const dvdx_live_plan* plan, char* text, size_t capacity);

#ifdef __cplusplus
}
#endif

#endif
