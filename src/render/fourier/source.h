/* The samples from which a spectrum is made. */
#ifndef CVOL_RENDER_FOURIER_SOURCE_H
#define CVOL_RENDER_FOURIER_SOURCE_H

#include "render/engine/engine.h"

/* The source of samples: one of the two. */
typedef struct cvol_fourier_source {
    const cvol_array *array;
    const cvol_volume *volume;
    double min, max; /* of samples with a value */
} cvol_fourier_source;

#endif
