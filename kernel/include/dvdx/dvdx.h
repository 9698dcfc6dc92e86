// dvdx for C99, and for everything that calls C: scenes are built up by functions, plans are made of them, and plans step the
// caller's own memory. No exception leaves these functions, none of them ends the program, and errors lie in the caller's
// memory.
//
// Units are SI. Every struct may be filled with zeros first: a zero is what most scenes want, or is refused with a message.
// Whatever a pointer points to is read during the call alone, but for the particles, which are always the caller's.
// Handles may be used by any number of threads, where none of them changes the handle or destroys it meanwhile.
#ifndef DVDX_DVDX_H
#define DVDX_DVDX_H

#include "dvdx/c/basics.h"
#include "dvdx/c/drawing.h"
#include "dvdx/c/instance.h"
#include "dvdx/c/live.h"
#include "dvdx/c/plan.h"
#include "dvdx/c/scene.h"

#endif
