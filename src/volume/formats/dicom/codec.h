/* Compressed frames of DICOM files: JPEG, JPEG-LS and JPEG 2000, by GDCM (gdcm.sourceforge.net),
 * which is C++ and slow to start. The rest of the library sees only this function, which a module
 * provides. */
#ifndef CVOL_VOLUME_FORMATS_DICOM_CODEC_H
#define CVOL_VOLUME_FORMATS_DICOM_CODEC_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define CVOL_DICOM_MODULE "cvol_gdcm.so"

typedef struct cvol_dicom_packed {
    const char *transfer; /* the transfer syntax's UID */
    const uint8_t *data;
    size_t size;
    uint32_t rows, columns, samples, allocated, stored, high, is_signed;
} cvol_dicom_packed;

/* Decodes a frame, whose headers were checked to have these rows, columns and samples, into `size`
 * bytes, in the machine's byte order, samples of a pixel together. 1 on success. */
__attribute__((visibility("default"))) int cvol_dicom_codec_decode(const cvol_dicom_packed *packed,
                                                                   void *out, size_t size);

#ifdef __cplusplus
}
#endif
#endif
