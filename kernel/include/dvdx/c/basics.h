// A part of dvdx/dvdx.h: errors, the library, and views of the caller's particles.
#ifndef DVDX_C_BASICS_H
#define DVDX_C_BASICS_H

#include <stddef.h>
#include <stdint.h>

#include "dvdx/export.h"
#include "dvdx/version.h"

#ifdef __cplusplus
extern "C" {
#endif

// ---- Errors ------------------------------------------------------------------------------------------------------------

// The result of a call. Unless its comment says otherwise, a call that does not return DVDX_DONE changes no scene, plan or
// particle.
typedef enum dvdx_status {
  DVDX_DONE = 0,
  DVDX_INVALID,              // a value is out of its range; the error names the field, the value and the range
  DVDX_OUT_OF_MEMORY,        // the allocator, or the program, has no memory left
  DVDX_COUNT_DIFFERS,        // the plan holds values for each particle, and the state has another count
  DVDX_CAPACITY_TOO_SMALL,   // a column's capacity is below the state's count
  DVDX_IN_USE,               // another thread steps this plan, or in this workspace: each serves one state at a time
  DVDX_PRECISION_DIFFERS,    // the state has another number type than the plan
  DVDX_ABI_DIFFERS,          // the caller was compiled for another DVDX_ABI_VERSION than this library's
  DVDX_FAILED,               // an unexpected failure; the message has the details
  DVDX_REPORT_DIFFERS,       // the report is for another number of contacts than the plan's scene has
  DVDX_WORKSPACE_DIFFERS,    // the workspace was made for another scene or precision
  DVDX_DRIVEN_ELSEWHERE,     // dvdx_plan_set_pose or its like drove the plan since the workspace was made, not the workspace
  DVDX_TOO_MANY_NEIGHBOURS,  // more than most_neighbours particles came within reach of one: the state is as it was
} dvdx_status;

// The error of a call, in the caller's memory; texts that do not fit are cut. Every call that takes it writes it, also one that
// returns DVDX_DONE: then all texts are empty. A null pointer asks for no message.
typedef struct dvdx_error {
  dvdx_status status;
  char field[96];     // "forces[2].stiffness"; empty if no field is to blame
  char value[96];     // "-40"
  char valid[192];    // "a finite number >= 0"
  char message[400];  // all of these in a sentence
} dvdx_error;

// Returns a status in a few words, in static memory.
DVDX_EXPORT const char* dvdx_status_text(dvdx_status status);

// ---- The library -------------------------------------------------------------------------------------------------------

// Return DVDX_VERSION and DVDX_ABI_VERSION of the library that the program runs with.
DVDX_EXPORT const char* dvdx_version(void);
DVDX_EXPORT int dvdx_abi_version(void);

// Writes version, compiler and instruction sets in a line: at most capacity bytes, including the ending zero. Returns the
// length of the whole text without the zero; 0: out of memory. text may be null if capacity is 0.
DVDX_EXPORT size_t dvdx_build_info(char* text, size_t capacity);

// ---- Particles ---------------------------------------------------------------------------------------------------------

typedef enum dvdx_precision { DVDX_FLOAT32 = 0, DVDX_FLOAT64 = 1 } dvdx_precision;

// One number per particle: element i lies at base + (i / run) * stride + (i % run) * size bytes, with size 4 or 8.
//   arrays (SoA)    run 0: all elements side by side; stride unused
//   structs (AoS)   run 1, stride the struct's size
//   tiles (AoSoA)   run the tile's width, stride a tile's bytes
// Elements from the count up to `capacity` are padding that a step may overwrite; nothing behind it is read or written. No two
// elements of a state's columns may share memory: DVDX_INVALID names the column.
typedef struct dvdx_column {
  void* base;        // aligned for its type, as is every element
  ptrdiff_t stride;  // bytes from a run to the next
  size_t run;        // 0, or a power of two
  size_t capacity;   // elements
} dvdx_column;

// The scene's time in s: the sum of both numbers, each finite.
typedef struct dvdx_clock {
  double seconds;
  double carry;
} dvdx_clock;

// The particles' columns, their count and the time.
typedef struct dvdx_state {
  dvdx_precision precision;
  dvdx_column x[3];  // m
  dvdx_column v[3];  // m/s
  size_t count;
  dvdx_clock clock;
  dvdx_column x_rest[3];  // for compensated plans alone: residuals, the part that x and v cannot hold
  dvdx_column v_rest[3];
} dvdx_state;

// Returns a view of six arrays of count numbers.
DVDX_EXPORT dvdx_state dvdx_soa(dvdx_precision precision, void* x, void* y, void* z, void* vx, void* vy, void* vz,
                                size_t count);

// Returns a view of structs that hold a position and a velocity as three consecutive numbers each:
//   dvdx_aos(DVDX_FLOAT32, p->position, p->velocity, sizeof *p, count)
DVDX_EXPORT dvdx_state dvdx_aos(dvdx_precision precision, void* first_position, void* first_velocity, size_t struct_bytes,
                                size_t count);

// Returns FNV-1a over x, y, z, vx, vy, vz, particle by particle, as `dvdx run --json` prints it. 0 for a null pointer, and for
// a state that no plan would step.
DVDX_EXPORT uint64_t dvdx_state_hash(const dvdx_state* state);

#ifdef __cplusplus
}
#endif

#endif
