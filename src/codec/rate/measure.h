/* Measures dense samples against their compressed array. */
#ifndef CVOL_CODEC_RATE_MEASURE_H
#define CVOL_CODEC_RATE_MEASURE_H

#include "array/block/brick.h"
#include "codec/brick/bricks.h"

/* The distance of an array from its original samples. */
typedef struct cvol_distance {
    double max_error, l2_error;           /* in the samples' own type: rounded and clamped */
    double real_max_error, real_l2_error; /* of evaluated samples, neither rounded nor clamped */
    double real_norm, real_max_abs;       /* L2 norm and largest magnitude of evaluated samples */
} cvol_distance;

/* Sets measured, max_error and psnr_db. */
void cvol_array_set_measured(cvol_array *array, const cvol_distance *distance);

/* The distances of the pieces in which an array is evaluated; L2 norms are squares. */
typedef struct cvol_piece_distances {
    cvol_distance *of;
    size_t count;
} cvol_piece_distances;

/* Compares the samples of a box, whole rows, with those of a slab. For volumes in cells of 16. The
 * result does not depend on the number of threads. what: the name for progress, or NULL. The caller
 * frees out->of. Errors: MEMORY, CANCELLED. */
int cvol_measure_pieces(cvol_context *context, cvol_piece_distances *out, const cvol_array *array,
                        const cvol_slab *slab, const cvol_box *box, const char *what);
/* Adds distances, which are squares, to *sum, in order. */
void cvol_distances_add(cvol_distance *sum, const cvol_distance *distances, size_t count);
/* Does both: adds squares and largest errors to *sum. */
int cvol_measure_box(cvol_context *context, cvol_distance *sum, const cvol_array *array,
                     const cvol_slab *slab, const cvol_box *box, const char *what);
/* The error that rounding may add when the array is evaluated in another way than it was measured:
 * terms and the offset may be much larger than their sum. */
double cvol_distance_rounding(const cvol_array *array, const cvol_distance *distance);
/* Sets l2_error, point_error and max_abs, with allowance for this rounding. */
void cvol_array_set_bounds(cvol_array *array, const cvol_distance *distance);
/* Turns sums of squares of this many samples into norms, or bounds of them: squares of magnitudes
 * below 1e-154 underflow, of those above 1e154 overflow. */
void cvol_distance_finish(cvol_distance *sum, size_t samples);

/* Evaluates all blocks and compares. The result does not depend on the number of threads. Errors:
 * MEMORY, CANCELLED. */
int cvol_measure_distance(cvol_context *context, cvol_distance *out, const cvol_array *array,
                          const void *samples);

#endif
