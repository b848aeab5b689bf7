/* The figures of cvol measure for a volume that is not compressed: exact ones. */
#ifndef CVOL_TOOLS_ALGEBRA_MEASURE_SAMPLES_H
#define CVOL_TOOLS_ALGEBRA_MEASURE_SAMPLES_H

#include "tools/base/cli.h"

/* Sets the statistics of the region, and counts the samples within least .. largest.
 * NaN and infinite samples, and those that are in->fill, if in->has_fill, do not count. Exit
 * status. */
int measure_samples(cvol_region_statistics *statistics, cvol_region *region, const input *in,
                    const size_t begin[3], const size_t end[3], cvol_region_shape shape,
                    double least, double largest);

#endif
