/* The choice of the low box of a truncation. */
#ifndef CVOL_ARRAY_TRUNCATE_LOW_BOX_H
#define CVOL_ARRAY_TRUNCATE_LOW_BOX_H

#include "array/truncate/candidates.h"

/* The number of values in a low box of this k; 0 if all are 0. */
size_t cvol_low_count(cvol_transform transform, const size_t dims[3], const size_t low[3]);

/* The low box with which `numbers` leave out the least energy. A term of the box counts one,
 * another one two, since its place is stored too. */
int cvol_low_box_for_count(cvol_context *context, size_t low[3], cvol_transform transform,
                           const size_t dims[3], const cvol_candidates *c, const float *keys,
                           double numbers);
/* The low box that leaves out `energy` with the fewest numbers. */
int cvol_low_box_for_energy(cvol_context *context, size_t low[3], cvol_transform transform,
                            const size_t dims[3], const cvol_candidates *c, const float *keys,
                            double energy);
/* The low box with the fewest numbers for all nonzero terms. Errors of all: MEMORY. */
int cvol_low_box_for_all(cvol_context *context, size_t low[3], cvol_transform transform,
                         const size_t dims[3], const cvol_candidates *c, const float *keys);

#endif
