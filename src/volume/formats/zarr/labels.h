/* The mark of labels in images of OME-Zarr. */
#ifndef CVOL_VOLUME_FORMATS_ZARR_LABELS_H
#define CVOL_VOLUME_FORMATS_ZARR_LABELS_H

#include "cvol/base.h"

/* *out: 1 for an image, or an array of one, whose group has the attribute image-label; 0 for
 * others, and for what is no image. Errors: IO, MEMORY. */
int cvol_zarr_find_label_mark(cvol_context *context, int *out, const char *path);

#endif
