/* Frames of DICOM files: raw, run-length coded, or by GDCM's codecs. */
#ifndef CVOL_VOLUME_FORMATS_DICOM_FRAME_H
#define CVOL_VOLUME_FORMATS_DICOM_FRAME_H

#include "volume/formats/dicom/head.h"

/* The type of stored samples. Checks first that the file's size fits the head's frames, and that
 * this build decodes them. */
int cvol_dicom_frame_check(cvol_context *context, const cvol_dicom_head *head, cvol_type *type);
/* One sample of each pixel of a frame of a head that was checked, in the machine's byte order. */
int cvol_dicom_frame_read(cvol_context *context, const cvol_dicom_head *head, uint64_t frame,
                          size_t sample, void *out);

#endif
