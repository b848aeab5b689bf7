/* Helpers for functions on pictures. */
#ifndef CVOL_IMAGE_PIXELS_H
#define CVOL_IMAGE_PIXELS_H

#include "cvol/image.h"

/* ARGUMENT unless the picture has bytes, or floats, and a valid size. `name` begins the message. */
int cvol_image_need_bytes(cvol_context *context, const cvol_image *image, const char *name);
int cvol_image_need_floats(cvol_context *context, const cvol_image *image, const char *name);

/* The output form of a pixel of floats: colour over a background and opacity 1, or (NULL) straight
 * colour and opacity, each within 0 and 1. */
void cvol_pixel_finish(float out[4], const float in[4], const double background[3]);

/* Writes a PNG of `channels` (1 grey, 3 RGB, 4 RGBA) of `bits` (8, or 16, high byte first); `fetch`
 * makes row y. Errors: IO, MEMORY. */
typedef struct cvol_png_rows {
    int width, height, channels, bits;
    void (*fetch)(const struct cvol_png_rows *rows, uint8_t *out, int y);
    const cvol_image *image;  /* the argument of fetch, */
    const double *background; /* and this */
} cvol_png_rows;
int cvol_png_write(cvol_context *context, const cvol_png_rows *rows, const char *path);

#endif
