/* Samples of a volume as they are decoded. */
#ifndef CVOL_VIEWER_SAMPLES_H
#define CVOL_VIEWER_SAMPLES_H

#include "volumes.h"

/* Those of a box, x fastest, as numbers; NaN: it has no value. The caller frees *out. */
int samples_read(cvol_context *context, double **out, const shown_volume *v, const size_t begin[3],
                 const size_t end[3]);
/* What is told of the sample nearest to a place (in samples, of the volume): its "value", what it
 * means, and where the place is in the file's world. NULL: the context says why. */
json_t *samples_describe(cvol_context *context, const shown_volume *v, const double place[3]);

#endif
