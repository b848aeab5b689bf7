/* Choosing the low box of a truncation. */
#ifndef CVOL_ARRAY_TRUNCATE_LOW_BOX_H
#define CVOL_ARRAY_TRUNCATE_LOW_BOX_H

#include "array/truncate/candidates.h"

/* How many numbers a low box of this k holds; 0 if all are 0. */
size_t cvol_low_count(cvol_transform transform, const size_t dims[3], const size_t low[3]);

/* The low box with which `numbers` (a term of the box is one, another one two: its place as well)
 * leave the least energy out. */
int cvol_low_for_numbers(cvol_context *context, size_t low[3], cvol_transform transform,
                         const size_t dims[3], const cvol_candidates *c, const float *keys,
                         double numbers);
/* The one that leaves out `energy` with the fewest numbers. */
int cvol_low_for_energy(cvol_context *context, size_t low[3], cvol_transform transform,
                        const size_t dims[3], const cvol_candidates *c, const float *keys,
                        double energy);
/* The one that takes the fewest numbers for all that is not 0. Errors of all: MEMORY. */
int cvol_low_for_all(cvol_context *context, size_t low[3], cvol_transform transform,
                     const size_t dims[3], const cvol_candidates *c, const float *keys);

#endif
