/* The intent code of NIfTI files. */
#ifndef CVOL_VOLUME_FORMATS_NIFTI_INTENT_H
#define CVOL_VOLUME_FORMATS_NIFTI_INTENT_H

#include "cvol/base.h"

/* *out: 1 for a NIfTI file, or the image of a pair, with the intent code of labels, 1002. Errors:
 * IO, MEMORY. */
int cvol_nifti_find_label_intent(cvol_context *context, int *out, const char *path);

#endif
