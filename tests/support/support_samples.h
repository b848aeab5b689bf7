/* Samples of any type, and a volume that tests of the codec compress. */
#ifndef CVOL_TESTS_SUPPORT_SAMPLES_H
#define CVOL_TESTS_SUPPORT_SAMPLES_H

#include "cvol/base.h"

/* Stores v, which lies within -1.2 .. 1.2, as a sample of the type: scaled to typical values of
 * such volumes. */
void support_store(void *samples, cvol_type type, size_t i, double v);
double support_load(const void *samples, cvol_type type, size_t i);

/* Waves, an oblique edge and noise, about -1 .. 2.2; the caller frees them. */
float *support_waves(const size_t dims[3]);

#endif
