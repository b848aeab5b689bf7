/* Frames of DICOM files: raw, run-length coded, or by GDCM's codecs. */
#ifndef CVOL_VOLUME_FORMATS_DICOM_FRAME_H
#define CVOL_VOLUME_FORMATS_DICOM_FRAME_H

#include "volume/formats/dicom/head.h"

/* The type of stored samples. First checks that the frames of the head fit the file's size, and
 * that this build decodes them. */
int cvol_dicom_frame_check(cvol_context *context, const cvol_dicom_head *head, cvol_type *type);
/* Reads one sample of each pixel of a frame of a checked head, in the machine's byte order. */
int cvol_dicom_frame_read(cvol_context *context, const cvol_dicom_head *head, uint64_t frame,
                          size_t sample, void *out);

#endif
