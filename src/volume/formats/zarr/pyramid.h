/* The levels of a volume that is written: each has half the samples of the one before along each
 * axis. A sample of level k is the mean of a box of 2^k samples along each axis (fewer at the end),
 * or for labels its first sample. */
#ifndef CVOL_VOLUME_FORMATS_ZARR_PYRAMID_H
#define CVOL_VOLUME_FORMATS_ZARR_PYRAMID_H

#include "cvol/base.h"

enum { CVOL_ZARR_LEVELS = 4, CVOL_ZARR_MISSING_MOST = 64 };

/* A level's boxes that are being summed up. */
typedef struct cvol_zarr_sums {
    size_t dims[3];
    double *sum;
    uint32_t *count; /* of samples with a value */
    size_t slices;   /* summed up, of the level before */
} cvol_zarr_sums;

/* Values of samples that have none, besides NaN and infinity. */
typedef struct cvol_zarr_missing {
    double values[CVOL_ZARR_MISSING_MOST];
    int count;
} cvol_zarr_missing;

typedef struct cvol_zarr_pyramid {
    int levels; /* with level 0 */
    int labels; /* first samples instead of means */
    int threads;
    cvol_type type;
    size_t dims[CVOL_ZARR_LEVELS][3];
    cvol_zarr_sums sums[CVOL_ZARR_LEVELS]; /* of level 1 and up */
    size_t slice;                          /* of level 0: the next one */
    cvol_zarr_missing missing;
} cvol_zarr_pyramid;

/* Receives the next slice of a level, in the type of the grid. */
typedef struct cvol_zarr_level_sink {
    int (*put)(cvol_context *context, void *user, int level, const void *slice);
    void *user;
} cvol_zarr_level_sink;

/* Errors: LIMIT. */
int cvol_zarr_missing_add(cvol_context *context, cvol_zarr_missing *missing, double value);
int cvol_zarr_has_value(const cvol_zarr_missing *missing, double sample);

/* The caller closes it, also after a failure. */
int cvol_zarr_pyramid_open(cvol_context *context, cvol_zarr_pyramid *pyramid, const cvol_grid *grid,
                           int labels);
void cvol_zarr_pyramid_close(cvol_zarr_pyramid *pyramid);
/* Adds the next slice of level 0, and hands over the slices of other levels that are complete.
 * After the last slice, the next volume begins. */
int cvol_zarr_pyramid_add(cvol_context *context, cvol_zarr_pyramid *pyramid, const void *slice,
                          const cvol_zarr_level_sink *sink);

#endif
