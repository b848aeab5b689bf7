/* Encoders of pictures as JPEG and WebP. In a build without their library they fail. */
#ifndef CVOL_IMAGE_PHOTO_H
#define CVOL_IMAGE_PHOTO_H

#include <stddef.h>

#include "cvol/image.h"

/* The picture has bytes, and the quality is valid. Errors: IO, MEMORY, LIMIT, UNSUPPORTED. */
int cvol_photo_write_jpeg(cvol_context *context, const cvol_image *image, int quality,
                          const char *path);
int cvol_photo_write_webp(cvol_context *context, const cvol_image *image, int quality,
                          const char *path);

/* Writes an encoded file. */
int cvol_photo_write_bytes(cvol_context *context, const void *bytes, size_t size, const char *path);

#endif
