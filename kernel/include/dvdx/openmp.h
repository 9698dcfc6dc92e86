// OpenMP's threads for C: the same team as OpenMpTeam in openmp.hpp. Link dvdx::openmp, or libdvdx_openmp.
#ifndef DVDX_OPENMP_H
#define DVDX_OPENMP_H

#include "dvdx/dvdx.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct dvdx_team dvdx_team;

// threads >= 1, the caller of a step among them; 0: as many as OpenMP would take. Null where the number is below 0, or where
// the system has no more threads or no more memory.
DVDX_EXPORT dvdx_team* dvdx_team_create(int threads);
// Not while a step uses it. A null pointer is fine.
DVDX_EXPORT void dvdx_team_destroy(dvdx_team* team);

// To be passed to steps, as long as the team is there. From a null pointer it is the caller alone.
DVDX_EXPORT dvdx_parallel dvdx_team_parallel(const dvdx_team* team);
DVDX_EXPORT int dvdx_team_threads(const dvdx_team* team);

#ifdef __cplusplus
}
#endif

#endif
