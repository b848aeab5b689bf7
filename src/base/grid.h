/* Checks of grids whose samples are never in memory all at once. */
#ifndef CVOL_BASE_GRID_H
#define CVOL_BASE_GRID_H

#include "cvol/base.h"

/* cvol_grid_check with a limit other than the context's; UINT64_MAX: bytes need only fit into
 * size_t. */
int cvol_grid_check_within(cvol_context *context, const cvol_grid *grid, const char *name,
                           uint64_t limit_bytes);

#endif
