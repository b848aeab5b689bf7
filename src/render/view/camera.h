/* The camera: where each pixel's ray runs, in world units (sample index times spacing), and what of
 * the volume is drawn.
 *
 * The box of sample centres is [0, extent] on each axis. Pixel (i, j), row j = 0 on top, sees
 *     p(i, j) = centre + (i + 1/2 - width / 2) pixel right + (height / 2 - j - 1/2) pixel up
 * in parallel projection along -eye, in perspective from `place`, which is `distance` eye before
 * `centre`.
 */
#ifndef CVOL_RENDER_VIEW_CAMERA_H
#define CVOL_RENDER_VIEW_CAMERA_H

#include "cvol/render.h"

/* Those of the clip, and what is too near to the eye. */
#define CVOL_VIEW_PLANES (CVOL_CLIP_PLANES + 1)

/* Blocks are evaluated on fewer points than they have samples only while a pixel of the picture
 * still spans 1 / CVOL_COARSEST_PITCH of them: less, and the picture is visibly softer than the
 * volume.
 */
#define CVOL_COARSEST_PITCH 0.7

typedef struct cvol_view {
    double right[3], up[3], eye[3]; /* orthonormal, right x up = eye (towards the viewer) */
    double centre[3], extent[3];    /* what is in the picture's middle; the box */
    int perspective;
    double place[3], distance; /* of the eye, in perspective */
    double ahead;              /* else depths are from the plane so far before the centre, */
                               /* wherever that is: the one that touches the ball about the box */
    double pixel;              /* world size of a pixel (at that distance) */
    double mean_spacing;       /* the length that opacity is given for */
    int width, height;
    double rays; /* of engine sheet: lines and columns of them for one of the picture, at least */
    /* Of its lattice: rays lie so many pixels apart, while that is within a sample, and points up
     * to so many where pixels span more (plan.h). */
    double apart, coarsest;
    double step;         /* between samples along rays, in mean spacings; 0: the engine's own */
    int clipped;         /* lo, hi are not all the faces of the volume, or there are planes */
    double lo[3], hi[3]; /* the box that is drawn, in sample indices: an axis of one sample is */
                         /* one spacing thick */
    int planes;          /* and what of it has plane . (x, y, z, 1) >= 0 in all, x y z in */
    double plane[CVOL_VIEW_PLANES][4]; /* sample indices, is drawn */
} cvol_view;

/* Whether pictures of the mode are grey levels, not colours. */
static inline int cvol_mode_is_grey(cvol_mode mode)
{
    return mode == CVOL_MODE_XRAY || mode == CVOL_MODE_MIP || mode == CVOL_MODE_MIN;
}

/* The view of a grid under these options. Errors: ARGUMENT (sizes, zoom, angles, step that have
 * no meaning, each named in the message; a clip that leaves nothing). */
int cvol_view_make(cvol_context *context, cvol_view *out, const cvol_grid *grid,
                   const cvol_render_options *options);

#endif
