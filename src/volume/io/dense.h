/* Dense volumes beyond the public functions, for readers and statistics. */
#ifndef CVOL_VOLUME_IO_DENSE_H
#define CVOL_VOLUME_IO_DENSE_H

#include "cvol/volume.h"

/* Allocates a volume of a grid that has passed cvol_grid_check; its samples are zero or
 * undefined. */
int cvol_dense_create(cvol_context *context, cvol_volume **out, const cvol_grid *grid, int zero);
/* ARGUMENT or LIMIT unless the caller's volume has samples and a valid grid. */
int cvol_dense_check(cvol_context *context, const cvol_volume *volume, const char *name);

#endif
