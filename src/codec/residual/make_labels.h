/* Makes labels in place of an array's residual (residual_labels.h). */
#ifndef CVOL_CODEC_RESIDUAL_MAKE_LABELS_H
#define CVOL_CODEC_RESIDUAL_MAKE_LABELS_H

#include "codec/residual/residual_array.h"

/* True if so many neighbours are equal that labels may take fewer bytes than a residual. */
int cvol_labels_may_fit(const void *samples, const cvol_grid *grid);

/* Codes all samples of an array, which may have no mask. *out: NULL if they take more than
 * `most_bytes`, or if a brick has too many labels. Errors: MEMORY. */
int cvol_labels_make(cvol_context *context, cvol_residual_data **out, const cvol_array *array,
                     const void *samples, double most_bytes);

#endif
