/* Makes labels in place of an array's residual (residual_labels.h). */
#ifndef CVOL_CODEC_RESIDUAL_MAKE_LABELS_H
#define CVOL_CODEC_RESIDUAL_MAKE_LABELS_H

#include "codec/residual/residual_array.h"

/* How well samples suit labels: not at all; perhaps, so that files with labels and with a residual
 * must be compared; or so well that labels are smaller if they also take far fewer bytes than zstd.
 */
typedef enum cvol_label_fit {
    CVOL_LABELS_NOT,
    CVOL_LABELS_PERHAPS,
    CVOL_LABELS_WELL
} cvol_label_fit;

/* Judges pairs of neighbours along x. Most must be equal. Terms suit smooth samples with small
 * steps between plateaus, so unequal neighbours must differ by 2 or more, unless there are few
 * values. Terms also suit labels whose faces are those of sub-blocks. */
cvol_label_fit cvol_labels_judge(const void *samples, const cvol_grid *grid);

/* Codes all samples of an array, which may have no mask. *out: NULL if they take more than
 * `most_bytes`, or if a brick has too many labels. Errors: MEMORY. */
int cvol_labels_make(cvol_context *context, cvol_residual_data **out, const cvol_array *array,
                     const void *samples, double most_bytes);

/* *out: 0 if all samples, coded as labels, take more than `most_bytes`, by an estimate from some
 * bricks, or if one of these has too many labels. Errors: MEMORY, DATA. */
int cvol_labels_may_fit(cvol_context *context, int *out, const cvol_array *array,
                        const void *samples, double most_bytes);

#endif
