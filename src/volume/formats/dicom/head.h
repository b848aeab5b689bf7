/* The frames that the header of a DICOM file describes. */
#ifndef CVOL_VOLUME_FORMATS_DICOM_HEAD_H
#define CVOL_VOLUME_FORMATS_DICOM_HEAD_H

#include "cvol/base.h"

/* Texts are cut at this length, trimmed and printable. */
#define CVOL_DICOM_TEXT 68

/* The properties that each frame of an enhanced multi-frame file may have. */
typedef struct cvol_dicom_frame {
    double position[3], slope, intercept;
    int has_position;
} cvol_dicom_frame;

typedef struct cvol_dicom_head {
    char *path;
    char transfer[CVOL_DICOM_TEXT], series_uid[CVOL_DICOM_TEXT], series_number[CVOL_DICOM_TEXT];
    char description[CVOL_DICOM_TEXT];
    double orientation[6], spacing[2], thickness, between; /* spacing: of rows, then of columns */
    int has_orientation;
    double time; /* distinguishes volumes at one position: acquisition, then instance */
    double instance;
    uint32_t rows, columns, samples, planar, allocated, stored, high, is_signed;
    uint64_t frames;
    cvol_dicom_frame *frame; /* `frames` of them */
    uint64_t pixels_at, pixels_size;
    int has_pixels, is_packed; /* packed: fragments, from pixels_at on */
    int big_endian;
} cvol_dicom_head;

/* 1 if a DICOM file begins with the bytes. */
int cvol_dicom_recognise(const uint8_t *head, size_t size);
/* Reads a header; the caller closes it, also after a failure. A file without pixels is no
 * failure. */
int cvol_dicom_head_read(cvol_context *context, cvol_dicom_head *head, const char *path);
void cvol_dicom_head_close(cvol_dicom_head *head);

#endif
