/* Making compressed pictures, from planes. */
#ifndef CVOL_IMAGE_PICTURE_H
#define CVOL_IMAGE_PICTURE_H

#include "codec/container/picture.h"

/* Planes of red, green, blue and opacity. */
typedef struct cvol_picture_source {
    const float *planes[CVOL_PICTURE_PLANES]; /* lattice[0] * lattice[1] each; the last NULL: opaque
                                               */
    size_t lattice[2];
    int width, height; /* pixels */
    int is_over; /* colours are premultiplied, to be composited over a background; else planes are
                    the pixels themselves, and so is the lattice */
    double background[3], to_intermediate[2][3]; /* if is_over: see spline_warp.h */
} cvol_picture_source;

/* Compresses planes. The target compares pixels of the compressed picture with those of the planes.
 * Errors: those of cvol_picture_compress. */
int cvol_picture_make(cvol_context *context, cvol_picture **out, const cvol_picture_source *source,
                      const cvol_picture_options *options);

/* Copies the options of a caller over the defaults. Errors: ARGUMENT (its size). */
int cvol_picture_options_complete(cvol_context *context, cvol_picture_options *out,
                                  const cvol_picture_options *options);

/* Pixels of red, green, blue and (NULL: opaque) opacity. Errors: MEMORY. */
int cvol_picture_draw_planes(cvol_context *context, cvol_image *image,
                             const cvol_picture_source *source);

/* Draws the picture into an image of its size. Errors: MEMORY, CANCELLED. */
int cvol_picture_draw(cvol_context *context, cvol_image *image, const cvol_picture *picture);

#endif
