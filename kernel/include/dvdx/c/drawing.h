// A part of dvdx/dvdx.h: what drawing needs.
#ifndef DVDX_C_DRAWING_H
#define DVDX_C_DRAWING_H

#include <stddef.h>
#include <stdint.h>

#include "dvdx/c/basics.h"
#include "dvdx/export.h"

#ifdef __cplusplus
extern "C" {
#endif

// The sum of the normals of the triangles that meet at a particle, each weighed by its area, at unit length; zero where that
// sum is. The sheet has particles first + row * columns + column; its cells are cut from (row, column) to (row + 1, column +
// 1). to: three columns of the state's precision for rows * columns numbers, which share no memory with it.
DVDX_EXPORT dvdx_status dvdx_grid_normals(size_t rows, size_t columns, size_t first, const dvdx_state* state,
                                          const dvdx_column* to, dvdx_error* error);
// The same of `count` triangles, three particles each, for every particle of the state: zero where no triangle is.
DVDX_EXPORT dvdx_status dvdx_triangle_normals(const uint32_t* corners, size_t count, const dvdx_state* state,
                                              const dvdx_column* to, dvdx_error* error);

typedef struct dvdx_bounds {
  double least[3];   // m, from the scene's origin; infinite where no particle counts
  double most[3];    // m
  size_t particles;  // whose place is finite: those that count
} dvdx_bounds;

// The box that holds the particles.
DVDX_EXPORT dvdx_status dvdx_state_bounds(const dvdx_state* state, dvdx_bounds* bounds, dvdx_error* error);

#ifdef __cplusplus
}
#endif

#endif
