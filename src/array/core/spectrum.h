/* The terms of a whole array: a dense low box and other, sparse terms, in slots
 * (transform/whole.h).
 *
 * Box index i of axis a is the place i if it is below low[a], else dims[a] - box[a] + i: under DFT
 * and DHT the negative frequencies follow the others, as in the whole spectrum. */
#ifndef CVOL_ARRAY_CORE_SPECTRUM_H
#define CVOL_ARRAY_CORE_SPECTRUM_H

#include "cvol/array.h"

typedef struct cvol_spectrum {
    size_t low[3]; /* k per axis: 1 <= k <= dims (DCT), <= dims / 2 + 1 (DFT, DHT); all 0: none */
    size_t box[3]; /* DCT: k; else min(2 k - 1, dims); 0 if there is none */
    size_t low_count;  /* their product */
    float *low_values; /* x fastest; NULL if there is none */
    uint32_t *places;  /* x + nx (y + ny z), strictly rising, none within the box */
    float *values;
    size_t sparse_count, sparse_capacity;
} cvol_spectrum;

/* Sets low and box for this k (clamped to the axis) and allocates low_values, zero. The rest is
 * empty. Errors: MEMORY. */
int cvol_spectrum_start(cvol_context *context, cvol_spectrum *out, cvol_transform transform,
                        const size_t dims[3], const size_t low[3]);
/* Reserves memory for `count` sparse terms in total. Errors: MEMORY. */
int cvol_spectrum_reserve(cvol_context *context, cvol_spectrum *spectrum, size_t count);
void cvol_spectrum_free(cvol_spectrum *spectrum);

/* The place of a box index, and the inverse: the box index, or SIZE_MAX if the place is outside. */
static inline size_t cvol_box_place(size_t index, size_t low, size_t box, size_t n)
{
    return index < low ? index : n - box + index;
}
static inline size_t cvol_box_index(size_t place, size_t low, size_t box, size_t n)
{
    if (place < low)
        return place;
    return n - place <= box - low ? place - (n - box) : SIZE_MAX;
}

/* Writes all terms to dense slots[N], zeros at other places. */
void cvol_spectrum_scatter(float *slots, const cvol_spectrum *spectrum, const size_t dims[3]);

/* The sum of squares, in double precision, in several parallel sums. */
double cvol_sum_squares(const float *values, size_t count);
/* The sum of squares of all terms. */
double cvol_spectrum_energy(const cvol_spectrum *spectrum);
/* The largest signed frequency's magnitude (DFT, DHT) or frequency (DCT) with a term, per axis. */
void cvol_spectrum_extent(size_t extent[3], const cvol_spectrum *spectrum, cvol_transform transform,
                          const size_t dims[3]);

#endif
