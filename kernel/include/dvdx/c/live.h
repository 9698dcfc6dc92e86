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
  double normal[3];          // of the disc, not zero
  double radius;             // m >= 0, of the disc
  double rate;               // particles/s >= 0
  double start;              // s: scene time from which on it works
  double duration;           // s > 0 for which it works; 0: for ever
  double velocity[3];        // m/s
  double spread;             // m/s >= 0: to the velocity is added what lies evenly in a ball of this radius,
  const double* spread_box;  // or in a box of these three half sides, m/s >= 0; null: in the ball
  double least_lifetime;     // s > 0; both 0: none dies of age
  double most_lifetime;      // s >= least: evenly between the two
  uint64_t seed;
  size_t follows;  // 1 + the index of the scene's motion that carries it from where it is written; 0: it rests
} dvdx_emitter;

// Particles are removed where normal . x < offset, the normal taken to unit length.
typedef struct dvdx_boundary {
  double normal[3];  // not zero
  double offset;     // m
} dvdx_boundary;

typedef enum dvdx_not_finite { DVDX_NOT_FINITE_KEPT = 0, DVDX_NOT_FINITE_REMOVED } dvdx_not_finite;

// In which order the others stand after some were removed: as before; or the last fill the holes, and nothing else is moved.
// Which fills which is the same for all instruction sets, threads, layouts and numbers of steps a call (dvdx/turnover.hpp).
typedef enum dvdx_survivor_order { DVDX_SURVIVOR_ORDER_KEPT = 0, DVDX_SURVIVOR_ORDER_ANY } dvdx_survivor_order;

// The emitters of particles, and their removal for other reasons than age.
typedef struct dvdx_turnover {
  const dvdx_emitter* emitters;
  size_t emitter_count;
  const dvdx_boundary* boundaries;
  size_t boundary_count;  // at most 8
  const double* inside;   // m: particles outside of this box are removed, min x y z, max x y z; null: none
  dvdx_not_finite not_finite;
  dvdx_survivor_order order;  // of those that stay
  size_t capacity;            // particles, 1 to 4294967295: most that live at once; further births are dropped and counted
} dvdx_turnover;

// A column of the caller's own that goes along with the particles: element i stands at base + i * stride bytes. Particles that
// are born get zeros.
typedef struct dvdx_carried {
  void* base;
  ptrdiff_t stride;  // bytes from an element to the next
  size_t bytes;      // of an element
} dvdx_carried;

// The live particles are the first state.count; every column must have room for the turnover's capacity.
typedef struct dvdx_live {
  dvdx_state state;
  dvdx_column age;                  // s since birth; base null: not kept
  dvdx_column lifetime;             // s; base null: none dies of age. Needs age
  const dvdx_carried* carried;      // null where carried_count is 0
  size_t carried_count;             // at most 32
  uint64_t born, removed, dropped;  // so far; dropped: births that found no room
} dvdx_live;

typedef struct dvdx_live_plan dvdx_live_plan;

// A plan for a scene whose particles are all alike, with neither networks, constraints, fixed or kinematic particles nor an
// origin, and a step > 0; the scene may be destroyed after it. Contacts and emitters may follow motions, and balls meet where
// they have one radius and no groups, and the others keep their order: see live.hpp.
DVDX_EXPORT dvdx_status dvdx_live_plan_create(const dvdx_scene* scene, const dvdx_turnover* turnover,
                                              const dvdx_options* options, dvdx_live_plan** plan, dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_live_plan_destroy(dvdx_live_plan* plan);

// As dvdx_plan_step(); after each step those that are to go are removed, the others keep their order (or fill the holes from
// the end: DVDX_SURVIVOR_ORDER_ANY), and the births of the step follow behind them. Steps one state at a time: else
// DVDX_IN_USE. DVDX_TOO_MANY_NEIGHBOURS of balls that meet: `live` is as it was when the step began that did not end.
DVDX_EXPORT dvdx_status dvdx_live_plan_step(const dvdx_live_plan* plan, dvdx_live* live, size_t steps,
                                            const dvdx_parallel* parallel, dvdx_error* error);
// The same, and reports, step by step. A particle's number is where it stood when its step began.
DVDX_EXPORT dvdx_status dvdx_live_plan_step_and_report(const dvdx_live_plan* plan, dvdx_live* live, size_t steps,
                                                       const dvdx_parallel* parallel, dvdx_contact_report* report,
                                                       dvdx_error* error);
// Removes what is to go as the particles stand, and moves nothing on. To remove one of your own choice, make its age infinite.
DVDX_EXPORT dvdx_status dvdx_live_plan_remove(const dvdx_live_plan* plan, dvdx_live* live, const dvdx_parallel* parallel,
                                              dvdx_error* error);
// As dvdx_plan_teleport(), of the particles that live and of what follows a motion. All else stays where it is.
DVDX_EXPORT dvdx_status dvdx_live_plan_teleport(const dvdx_live_plan* plan, const dvdx_live* live, const double* translation,
                                                const double* rotation, dvdx_error* error);
// A plan for another state, as dvdx_plan_clone().
DVDX_EXPORT dvdx_status dvdx_live_plan_clone(const dvdx_live_plan* plan, dvdx_live_plan** clone, dvdx_error* error);
// As dvdx_plan_set_pose(), jump_pose(), set_wind() and check().
DVDX_EXPORT dvdx_status dvdx_live_plan_set_pose(dvdx_live_plan* plan, size_t motion, const double* translation,
                                                const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_jump_pose(dvdx_live_plan* plan, size_t motion, const double* translation,
                                                 const double* rotation, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_set_wind(dvdx_live_plan* plan, const dvdx_wind* wind, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_check(const dvdx_live_plan* plan, const dvdx_live* live, dvdx_state_check* check,
                                             dvdx_error* error);
DVDX_EXPORT double dvdx_live_plan_step_size(const dvdx_live_plan* plan);  // s; a null pointer's is not a number
// Changes: see live.hpp. A force or a contact becomes one of a scene's; a contact is there at once.
DVDX_EXPORT dvdx_status dvdx_live_plan_set_step(dvdx_live_plan* plan, double step, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_set_force(dvdx_live_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                                 dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_set_contact(dvdx_live_plan* plan, size_t index, const dvdx_scene* scene, size_t from,
                                                   dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_live_plan_set_emitter(dvdx_live_plan* plan, size_t index, const dvdx_emitter* emitter,
                                                   dvdx_error* error);
// So many births of an emitter at once.
DVDX_EXPORT dvdx_status dvdx_live_plan_burst(const dvdx_live_plan* plan, dvdx_live* live, size_t index, size_t births,
                                             dvdx_error* error);
// As dvdx_workspace: what one state is stepped in, and what drives it. report may be null.
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
// The cost of coming and going, in words, behind the scene's needs. As dvdx_build_info().
DVDX_EXPORT size_t dvdx_live_plan_explain(const dvdx_live_plan* plan, char* text, size_t capacity);

#ifdef __cplusplus
}
#endif

#endif
