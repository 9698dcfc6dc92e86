// A part of dvdx/dvdx.h: instances of a plan, one for each state.
#ifndef DVDX_C_INSTANCE_H
#define DVDX_C_INSTANCE_H

#include <stddef.h>

#include "dvdx/c/plan.h"
#include "dvdx/export.h"

#ifdef __cplusplus
extern "C" {
#endif

// A state with its driven things, its wind, its frame time and its springs' history. Instances share their plan's compiled
// scene; the plan may be destroyed after them or before. Any number of threads may step different instances at once. See
// instance.hpp.
typedef struct dvdx_instance dvdx_instance;
typedef enum dvdx_arrival { DVDX_MOVING = 0, DVDX_JUMP } dvdx_arrival;

// state: the program owns its columns, which must stay where they are. Its clock lives in the instance from now on.
DVDX_EXPORT dvdx_status dvdx_instance_create(const dvdx_plan* plan, const dvdx_state* state, dvdx_instance** instance,
                                             dvdx_error* error);
// A null pointer is fine.
DVDX_EXPORT void dvdx_instance_destroy(dvdx_instance* instance);
// "Be there at the end of the next step", or of the next call of advance; by DVDX_JUMP at once. See dvdx_plan_set_pose(),
// dvdx_plan_set_places() and dvdx_plan_set_skin().
DVDX_EXPORT dvdx_status dvdx_instance_move_body(dvdx_instance* instance, size_t motion, const double* translation,
                                                const double* rotation, dvdx_arrival arrival, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_instance_move_pins(dvdx_instance* instance, size_t kinematic, const double* places, size_t count,
                                                dvdx_arrival arrival, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_instance_move_skin(dvdx_instance* instance, size_t skin, const double* points,
                                                const double* normals, size_t count, dvdx_arrival arrival, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_instance_set_wind(dvdx_instance* instance, const dvdx_wind* wind, dvdx_error* error);
// Makes one step of this length, s.
DVDX_EXPORT dvdx_status dvdx_instance_step(dvdx_instance* instance, double step, const dvdx_parallel* parallel,
                                           dvdx_error* error);
// Makes one step of each of `count` instances, shared among the threads of `parallel`. All have one precision, and none is
// listed twice. frame_times: s, one (time_count 1) or one for each. An error names the first instance that failed, as
// instances[k]; all others have stepped.
DVDX_EXPORT dvdx_status dvdx_instances_step(dvdx_instance* const* instances, size_t count, const double* frame_times,
                                            size_t time_count, const dvdx_parallel* parallel, dvdx_error* error);
// Makes whole steps of the plan's size: as many as are due, at most `most`. *steps gets their number; steps may be null.
DVDX_EXPORT dvdx_status dvdx_instance_advance(dvdx_instance* instance, double frame_time, size_t most, size_t* steps,
                                              const dvdx_parallel* parallel, dvdx_error* error);
// Writes the particles between the last two steps of advance, for drawing, into columns of the same count and precision.
DVDX_EXPORT dvdx_status dvdx_instance_blend(const dvdx_instance* instance, const dvdx_state* to, dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_instance_teleport(dvdx_instance* instance, const double* translation, const double* rotation,
                                               dvdx_error* error);
DVDX_EXPORT dvdx_status dvdx_instance_check(const dvdx_instance* instance, dvdx_state_check* check, dvdx_error* error);
// A null pointer gives NaN.
DVDX_EXPORT dvdx_clock dvdx_instance_clock(const dvdx_instance* instance);
DVDX_EXPORT double dvdx_instance_step_size(const dvdx_instance* instance);  // s

#ifdef __cplusplus
}
#endif

#endif
