/* The samples from which a spectrum is made. */
#ifndef CVOL_RENDER_FOURIER_SOURCE_H
#define CVOL_RENDER_FOURIER_SOURCE_H

#include "render/engine/engine.h"

/* The source of samples: one of the two. */
typedef struct cvol_fourier_source {
    const cvol_array *array;
    const cvol_volume *volume;
    double min, max; /* of samples with a value, less the offset */
    double offset; /* of the array, or the least sample: samples are loaded less it, so that single
                      precision suffices for values far from 0 */
} cvol_fourier_source;

#endif
