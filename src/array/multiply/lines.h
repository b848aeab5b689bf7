/* Converts between a box of slots around the origin (transform/whole.h, spectrum.h) and the
 * coefficients for transforms along one axis, with zeros between: pairs of floats F[u, v, w] with u
 * >= 0 only (DFT, DHT; the rest are conjugates), or floats A[u, v, w] (DCT).
 *
 * Axes are inner, mid, outer: x, y, z, but in two dimensions x, 1, y, so that the outer axis is
 * always the long one. The axis of length 1 changes neither the order of slots nor the first place
 * of a pair, so the slots are the same. */
#ifndef CVOL_ARRAY_MULTIPLY_LINES_H
#define CVOL_ARRAY_MULTIPLY_LINES_H

#include "array/core/spectrum.h"

/* A box of slots of a grid of n places per axis; see cvol_spectrum. */
typedef struct cvol_slot_box {
    cvol_transform transform;
    size_t n[3], low[3], box[3];
} cvol_slot_box;

/* The box of this k (at least 1) on axes of n places. */
cvol_slot_box cvol_slot_box_of(cvol_transform transform, const size_t n[3], const size_t low[3]);

static inline size_t cvol_slot_box_count(const cvol_slot_box *box)
{
    return box->box[0] * box->box[1] * box->box[2];
}

/* lines[w][u - begin] = scale times the coefficient [u, v, w] of slots, begin <= u < begin + count,
 * w over `points` places of the outer axis (a frequency -f at points - f); v is a box index. DCT:
 * an additional factor of sqrt 2 for each frequency of 0, which is c(0) / c(u). */
void cvol_lines_load(float *lines, size_t points, const float *slots, const cvol_slot_box *box,
                     size_t v, size_t begin, size_t count, double scale);

/* The inverse, for one outer place: box index w. DCT: a factor of sqrt 1/2 for each frequency of 0.
 * Every pair is written by its first place. */
void cvol_lines_store(float *slots, const cvol_slot_box *box, const float *line, size_t v, size_t w,
                      size_t begin, size_t count);

#endif
