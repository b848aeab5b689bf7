/* Members of a compressed picture, and its file. */
#ifndef CVOL_CODEC_CONTAINER_PICTURE_H
#define CVOL_CODEC_CONTAINER_PICTURE_H

#include "array/core/array.h"
#include "base/bytes.h"
#include "cvol/picture.h"

enum { CVOL_PICTURE_COLOURS = 3, CVOL_PICTURE_OPACITY = 3, CVOL_PICTURE_PLANES = 4 };

struct cvol_picture {
    int width, height, is_over;
    double to_intermediate[2][3], background[3];
    size_t lattice[2];
    cvol_transform transform;
    int block, plane_count;
    cvol_array *planes[CVOL_PICTURE_PLANES]; /* quantized by their steps */
    double steps[CVOL_PICTURE_PLANES];
    double psnr_db;
};

/* Appends the file. Errors: DATA, MEMORY. */
int cvol_picture_put(cvol_context *context, cvol_bytes *out, const cvol_picture *picture);
/* Reads a file. Errors: as cvol_picture_read, except IO. */
int cvol_picture_take(cvol_context *context, cvol_picture **out, const uint8_t *data, size_t size,
                      const char *name);

#endif
