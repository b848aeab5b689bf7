/* The samples that a spectrum is made from. */
#ifndef CVOL_RENDER_FOURIER_SOURCE_H
#define CVOL_RENDER_FOURIER_SOURCE_H

#include "render/engine/engine.h"

/* Where samples come from: one of the two. */
typedef struct cvol_fourier_source {
    const cvol_array *array;
    const cvol_volume *volume;
    double min, max; /* of samples that have a value */
} cvol_fourier_source;

#endif
