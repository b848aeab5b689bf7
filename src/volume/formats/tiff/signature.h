/* The signature of TIFF files. */
#ifndef CVOL_VOLUME_FORMATS_TIFF_SIGNATURE_H
#define CVOL_VOLUME_FORMATS_TIFF_SIGNATURE_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* 1 for TIFF and BigTIFF, in either byte order. */
static inline int cvol_tiff_recognise(const uint8_t *head, size_t size)
{
    return size >= 8 && (!memcmp(head, "II*\0", 4) || !memcmp(head, "MM\0*", 4) ||
                         !memcmp(head, "II+\0", 4) || !memcmp(head, "MM\0+", 4));
}

#endif
