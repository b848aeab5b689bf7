/* Checks of grids that files state. */
#ifndef CVOL_BASE_GRID_H
#define CVOL_BASE_GRID_H

#include "cvol/base.h"

/* cvol_grid_check for the grid of a file, which is to blame. Errors: FORMAT, LIMIT. */
int cvol_grid_check_file(cvol_context *context, const cvol_grid *grid, const char *name);
/* The same with a limit other than the context's, for samples that are never in memory all at once;
 * UINT64_MAX: bytes need only fit into size_t. */
int cvol_grid_check_within(cvol_context *context, const cvol_grid *grid, const char *name,
                           uint64_t limit_bytes);

#endif
