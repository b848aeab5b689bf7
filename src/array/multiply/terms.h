/* An operand's terms as complex exponentials of signed frequencies, for the product term by term.
 *
 * Each has an index f_x + W_x (f_y + W_y f_z) on a hull of W places per axis. The hull is wide
 * enough for sums of two frequencies, so the index of a product is the sum of the indices. */
#ifndef CVOL_ARRAY_MULTIPLY_TERMS_H
#define CVOL_ARRAY_MULTIPLY_TERMS_H

#include "array/core/array.h"

/* The hull of the products: frequencies -extent .. extent, width = 2 extent + 1. */
typedef struct cvol_hull {
    int64_t extent[3], width[3], count;
} cvol_hull;

cvol_hull cvol_hull_of(const cvol_array *a, const cvol_array *b);

typedef struct cvol_exponential {
    int64_t index;
    double re, im;
} cvol_exponential;

typedef struct cvol_exponentials {
    cvol_exponential *list; /* indices rise */
    size_t count;
} cvol_exponentials;

/* DFT, DHT: F[u]; all != 0: of every frequency; else the first of each pair, and one half of a
 * frequency that is its own mirror. DCT: the amplitudes of cosines; all != 0: each split evenly
 * over the signs of its frequencies. Terms of 0 are left out. Free with free(list). Errors:
 * MEMORY. */
int cvol_exponentials_list(cvol_context *context, cvol_exponentials *out, const cvol_array *a,
                           const cvol_hull *hull, int all);

/* An accumulated product to slots: sums[i] at hull index index[i] (counted from the hull's first
 * place). Places rise; exact zeros are left out. */
typedef struct cvol_listed_slots {
    uint32_t *places;
    float *values;
    size_t count;
    double energy;
} cvol_listed_slots;
/* Folds frequencies as sampling on the array's places does. DFT, DHT: u is u - n. DCT: beyond n,
 * cos(pi u (x + 1/2) / n) is -cos(pi (2 n - u) (x + 1/2) / n), and at n it is 0. */
int cvol_listed_slots_fold(cvol_context *context, cvol_listed_slots *out, const cvol_array *like,
                           const cvol_hull *hull, const cvol_exponential *sums, size_t count);
void cvol_listed_slots_free(cvol_listed_slots *slots);

#endif
