/* Samples for a spectrum, some slices at a time. */
#ifndef CVOL_RENDER_FOURIER_SLAB_H
#define CVOL_RENDER_FOURIER_SLAB_H

#include "render/fourier/source.h"

/* Slices first .. first + count - 1. */
typedef struct cvol_fourier_slab {
    float *samples;
    uint8_t *mask; /* NULL: all samples have a value */
    size_t first, count, most;
} cvol_fourier_slab;

/* Allocates, before the first slice. Errors: MEMORY; the caller frees in that case, too. */
int cvol_fourier_slab_make(cvol_context *context, cvol_fourier_slab *out,
                           const cvol_fourier_source *source, const size_t n[3]);
void cvol_fourier_slab_free(cvol_fourier_slab *of);
/* Loads the next slices. Errors: as evaluation. */
int cvol_fourier_slab_next(cvol_context *context, cvol_fourier_slab *of,
                           const cvol_fourier_source *source, const size_t n[3]);
/* The mean of the samples at the sides. After subtracting it, the volume mostly has no visible edge
 * there. */
double cvol_fourier_slab_base(const cvol_fourier_slab *of, const size_t n[3], double otherwise);

#endif
