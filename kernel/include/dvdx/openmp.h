// OpenMP's threads for C: the same team as OpenMpTeam in openmp.hpp. Link dvdx::openmp, or libdvdx_openmp.
#ifndef DVDX_OPENMP_H
#define DVDX_OPENMP_H

#include "dvdx/dvdx.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct dvdx_team dvdx_team;

// threads >= 1, including the caller of a step; 0: OpenMP's own number. Returns null if threads < 0, or if the system has no
// more threads or no more memory.
DVDX_EXPORT dvdx_team* dvdx_team_create(int threads);
// Not while a step uses it. A null pointer is fine.
DVDX_EXPORT void dvdx_team_destroy(dvdx_team* team);

// Returns the argument for steps; valid as long as the team. A null team means the calling thread alone.
DVDX_EXPORT dvdx_parallel dvdx_team_parallel(const dvdx_team* team);
DVDX_EXPORT int dvdx_team_threads(const dvdx_team* team);

#ifdef __cplusplus
}
#endif

#endif
