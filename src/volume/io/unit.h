/* Units of length, as grids name them. */
#ifndef CVOL_VOLUME_IO_UNIT_H
#define CVOL_VOLUME_IO_UNIT_H

#include <stddef.h>

/* Metres in a unit of length; 0: another unit, or none. */
double cvol_unit_metres(const char *unit);

/* The name that grids have for a unit of length, which files name in many ways: "um" for "micron".
 * NULL: another unit, or none. */
const char *cvol_unit_of_length(const char *text, size_t size);

/* The common unit of three axes: that of the first axis that has one; "": the unit of an axis is
 * unknown, and taken to be the common one. Lengths of axis a times factor[a] are in unit `common`,
 * a name of the grid. 0: two units differ, and are not both units of length. */
int cvol_unit_factors(double factor[3], char common[16], const char *const unit[3]);

#endif
