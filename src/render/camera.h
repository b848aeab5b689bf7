/* The parallel camera: where each pixel's ray runs, in world units (sample index times spacing).
 *
 * The box of sample centres is [0, extent] on each axis. Pixel (i, j), row j = 0 on top, looks
 * along -eye through
 *     p(i, j) = centre + (i + 1/2 - width / 2) pixel right + (height / 2 - j - 1/2) pixel up
 */
#ifndef CVOL_RENDER_CAMERA_H
#define CVOL_RENDER_CAMERA_H

#include "cvol/render.h"

typedef struct cvol_view {
    double right[3], up[3], eye[3]; /* orthonormal, right x up = eye (towards the viewer) */
    double centre[3], extent[3];
    double pixel;        /* world size of a pixel */
    double mean_spacing; /* the length that opacity is given for */
    int width, height;
} cvol_view;

/* The view of a grid under these options. Errors: ARGUMENT (sizes, zoom, angles, step that have
 * no meaning, each named in the message). */
int cvol_view_make(cvol_context *context, cvol_view *out, const cvol_grid *grid,
                   const cvol_render_options *options);

#endif
