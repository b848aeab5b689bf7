/* The box of a small object. */
#ifndef CVOL_RENDER_LOOK_FIT_SMALL_H
#define CVOL_RENDER_LOOK_FIT_SMALL_H

#include "cvol/render.h"

/* A box along the axes, in the unit of the volume, from its middle. */
typedef struct cvol_small_box {
    double middle[3], half[3];
} cvol_small_box;

/* Finds the box of the samples that are visible in mode composite or iso, where the means of larger
 * cells are not. *found: 0 if there are none, if the volume is too large to look at every sample,
 * and in other modes. Errors: MEMORY, CANCELLED. */
int cvol_small_box_find(cvol_context *context, cvol_small_box *out, int *found,
                        const cvol_source *of, const cvol_transfer *transfer,
                        const cvol_render_options *options);

#endif
