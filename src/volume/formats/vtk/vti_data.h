/* Data arrays of VTK's XML files: base64 and blocks of zlib. */
#ifndef CVOL_VOLUME_FORMATS_VTK_VTI_DATA_H
#define CVOL_VOLUME_FORMATS_VTK_VTI_DATA_H

#include "cvol/base.h"

/* The encoding of a file's arrays. */
typedef struct cvol_vti_coding {
    int big_endian, is_zlib;
    size_t word; /* bytes of the integers before an array: 4 or 8 */
} cvol_vti_coding;

/* An integer of coding->word bytes. */
uint64_t cvol_vti_integer(const cvol_vti_coding *coding, const uint8_t *bytes);
/* Decodes base64 in place, up to the first other byte; units with their own padding may follow each
 * other. Returns the number of decoded bytes. */
size_t cvol_vti_base64(uint8_t *text, size_t size);
/* Decodes the array that begins with its header at bytes[0]: `wanted` bytes, which the caller
 * frees. FORMAT error if it has another number of bytes, or is damaged. */
int cvol_vti_unpack(cvol_context *context, uint8_t **out, const cvol_vti_coding *coding,
                    const uint8_t *bytes, size_t size, size_t wanted, const char *path);

#endif
