// dvdx for C99, and for every language that calls C. Functions build a scene, compile it to a plan, and step the caller's own
// memory by the plan. No exception leaves these functions, none of them ends the program, and errors lie in the caller's
// memory.
//
// Units are SI. Every struct may be zero-filled first: zero is the usual value of a field, or is refused with a message.
// Data behind a pointer is read during the call alone, except for the particles, which stay the caller's.
// Any number of threads may use a handle while no thread changes or destroys it.
#ifndef DVDX_DVDX_H
#define DVDX_DVDX_H

#include "dvdx/c/basics.h"
#include "dvdx/c/drawing.h"
#include "dvdx/c/instance.h"
#include "dvdx/c/live.h"
#include "dvdx/c/plan.h"
#include "dvdx/c/scene.h"

#endif
