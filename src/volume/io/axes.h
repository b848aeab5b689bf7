/* Arrays of more than three axes as volumes: which axes are z, y, x, and which are chosen from. */
#ifndef CVOL_VOLUME_IO_AXES_H
#define CVOL_VOLUME_IO_AXES_H

#include "cvol/volume.h"
#include "volume/io/stored.h"

#define CVOL_AXES_MOST 8

/* Axes are numbered from 0, and the last one runs fastest. */
typedef struct cvol_axes {
    int rank;
    uint64_t dims[CVOL_AXES_MOST];
    int of[3];                      /* x, y, z: their axes; -1: there is none, and one place */
    uint64_t begin[CVOL_AXES_MOST]; /* of the volume that was chosen */
} cvol_axes;

/* Of an array whose rank and dims are set, finds the others, and the grid's dims. Up to three axes
 * are z, y, x. Of more, the last one has channels where it has at most four places (colours); else
 * the three last are z, y, x, and of two in front of them (leading ones of one place do not count)
 * the second has channels. What is left in front has volumes. Others must have one place.
 * Errors: those of cvol_format_choose, UNSUPPORTED. */
int cvol_axes_choose(cvol_context *context, cvol_axes *axes, cvol_grid *grid, const char *path,
                     const cvol_read_options *options);

/* Bytes whose last axis has three or four places, and is of channels, are colours: says so. 1, or 0
 * where memory is short. */
int cvol_axes_label(cvol_labels *labels, const cvol_axes *axes, cvol_type type);

#endif
