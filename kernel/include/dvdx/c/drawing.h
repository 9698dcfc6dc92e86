// A part of dvdx/dvdx.h: geometry for drawing.
#ifndef DVDX_C_DRAWING_H
#define DVDX_C_DRAWING_H

#include <stddef.h>
#include <stdint.h>

#include "dvdx/c/basics.h"
#include "dvdx/export.h"

#ifdef __cplusplus
extern "C" {
#endif

// Writes the unit normal at each particle: the direction of the area-weighted sum of its triangles' normals; zero if the sum
// is. The sheet has particles first + row * columns + column; its cells are cut from (row, column) to (row + 1, column + 1).
// to: three columns of the state's precision for rows * columns numbers; they share no memory with the state.
DVDX_EXPORT dvdx_status dvdx_grid_normals(size_t rows, size_t columns, size_t first, const dvdx_state* state,
                                          const dvdx_column* to, dvdx_error* error);
// The same for `count` triangles, three particles each, and every particle of the state: zero without a triangle.
DVDX_EXPORT dvdx_status dvdx_triangle_normals(const uint32_t* corners, size_t count, const dvdx_state* state,
                                              const dvdx_column* to, dvdx_error* error);

typedef struct dvdx_bounds {
  double least[3];   // m, from the scene's origin; infinity if no particle counts
  double most[3];    // m; minus infinity if no particle counts
  size_t particles;  // counted: those with a finite position
} dvdx_bounds;

// Computes the box that holds the particles.
DVDX_EXPORT dvdx_status dvdx_state_bounds(const dvdx_state* state, dvdx_bounds* bounds, dvdx_error* error);

#ifdef __cplusplus
}
#endif

#endif
