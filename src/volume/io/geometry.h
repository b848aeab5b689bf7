/* The directions of axes in the world: vectors of files to spacing and direction, and back. */
#ifndef CVOL_VOLUME_IO_GEOMETRY_H
#define CVOL_VOLUME_IO_GEOMETRY_H

#include "cvol/base.h"

/* Sets spacing and direction of an axis from the step between its neighbours; 0 if the step is
 * zero or not finite, then the grid stays as it was. */
int cvol_geometry_set_axis(cvol_grid *grid, int axis, const double step[3]);
/* The same for the direction alone: the axis keeps its spacing. */
int cvol_geometry_set_direction(cvol_grid *grid, int axis, const double vector[3]);
/* Gives unknown axes a direction perpendicular to the known ones, and keeps their spacing: an image
 * in space gets its normal. */
void cvol_geometry_complete(cvol_grid *grid, const int known[3]);
/* FORMAT error unless the three directions span the space. `name` begins the message. */
int cvol_geometry_check(cvol_context *context, const cvol_grid *grid, const char *name);
/* Converts to another space: LPS and RAS differ in the signs of two world axes. From or to UNKNOWN
 * only the name changes. */
cvol_grid cvol_geometry_in_space(const cvol_grid *grid, cvol_space space);
/* Converts lengths to micrometres, or from 1 mm on to millimetres, for a format that has no field
 * for the grid's unit. `kept`: the `count` units that it has. Other units than those of length
 * stay. */
cvol_grid cvol_geometry_in_unit(const cvol_grid *grid, const char *const *kept, size_t count);
/* Changes the sign of one world axis. */
void cvol_geometry_mirror(cvol_grid *grid, int world_axis);

#endif
