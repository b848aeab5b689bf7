/* Decoded samples of a volume. */
#ifndef CVOL_VIEWER_VOLUMES_SAMPLES_H
#define CVOL_VIEWER_VOLUMES_SAMPLES_H

#include "viewer/volumes/volumes.h"

/* Reads the samples of a box, x fastest, as numbers; NaN: no value. The caller frees *out. */
int samples_read(cvol_context *context, double **out, const shown_volume *v, const size_t begin[3],
                 const size_t end[3]);
/* The same of an array. */
int samples_read_array(cvol_context *context, double **out, const cvol_array *array,
                       const size_t begin[3], const size_t end[3]);
/* Describes the sample nearest to a place (in samples): "value", "meaning" after the rescale, and
 * the "world" position of the place. The caller owns *out. */
int samples_describe(cvol_context *context, json_t **out, const shown_volume *v,
                     const double place[3]);

#endif
