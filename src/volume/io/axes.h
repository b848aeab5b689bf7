/* Arrays of more than three axes as volumes: the axes z, y, x, and those from which one index is
 * chosen. */
#ifndef CVOL_VOLUME_IO_AXES_H
#define CVOL_VOLUME_IO_AXES_H

#include "cvol/volume.h"
#include "volume/io/stored.h"

#define CVOL_AXES_MAX 8

/* Axes are numbered from 0, and the last one runs fastest. */
typedef struct cvol_axes {
    int rank;
    uint64_t dims[CVOL_AXES_MAX];
    int of[3];                     /* x, y, z: their axes; -1: there is none, size 1 */
    uint64_t begin[CVOL_AXES_MAX]; /* of the chosen volume */
} cvol_axes;

/* Sets `of`, `begin` and the grid's dims by rank and dims. Up to three axes are z, y, x. With more
 * axes, a last one of size 4 or less has channels (colours). Otherwise the last three are z, y, x,
 * and the second of two in front of them has channels (leading axes of size 1 do not count). A
 * remaining axis in front has volumes; all others must have size 1. Errors: those of
 * cvol_format_choose, UNSUPPORTED. */
int cvol_axes_choose(cvol_context *context, cvol_axes *axes, cvol_grid *grid, const char *path,
                     const cvol_read_options *options);

/* Labels the channels as colours if samples are bytes and the last axis has three or four channels.
 * 1, or 0 without memory. */
int cvol_axes_label(cvol_labels *labels, const cvol_axes *axes, cvol_type type);

#endif
