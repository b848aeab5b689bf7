/* Units of length, as grids name them. */
#ifndef CVOL_VOLUME_IO_UNIT_H
#define CVOL_VOLUME_IO_UNIT_H

/* Metres in a unit of length; 0: another unit, or none. */
double cvol_unit_metres(const char *unit);

#endif
