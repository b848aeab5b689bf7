/* Colours of labels: numbers of regions. */
#ifndef CVOL_RENDER_LOOK_LABELS_H
#define CVOL_RENDER_LOOK_LABELS_H

#include "cvol/transfer.h"

/* Returns 1 if the values are integers, and so few that they name regions. */
int cvol_labels_are_few(const cvol_histogram *histogram);
/* Gives each label a colour of its own; 0, or else the most frequent one, is the background.
 * Errors: MEMORY. */
int cvol_labels_create_transfer(cvol_context *context, cvol_transfer **out,
                                const cvol_histogram *histogram);

#endif
