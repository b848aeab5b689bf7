/* One slice as a picture: PNG or JPEG. */
#ifndef CVOL_VOLUME_FORMATS_PICTURES_PICTURE_H
#define CVOL_VOLUME_FORMATS_PICTURES_PICTURE_H

#include <stdint.h>

#include "cvol/base.h"

typedef struct cvol_picture {
    size_t width, height;
    int channels;    /* 1: grey; 3: red, green, blue */
    int bits;        /* of a channel: 8 or 16 */
    uint8_t *pixels; /* top row first, in the machine's byte order; freed with free() */
} cvol_picture;

/* Decode a file; the caller frees out->pixels. Palettes become colours, or grey levels if all are
 * grey; transparency is left out. Errors: IO, FORMAT, LIMIT, MEMORY, UNSUPPORTED (a build without
 * the library). */
int cvol_picture_read_png(cvol_context *context, cvol_picture *out, const char *path);
int cvol_picture_read_jpeg(cvol_context *context, cvol_picture *out, const char *path);

/* Errors: LIMIT (more bytes than the context allows), FORMAT (a size of zero). */
int cvol_picture_check(cvol_context *context, const cvol_picture *picture, const char *path);

#endif
