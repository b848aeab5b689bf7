/* A view: the ray of each pixel, in world units (sample index times spacing), and the drawn
 * part of the volume.
 *
 * The box of sample centres is [0, extent] on each axis. Pixel (i, j), row j = 0 on top, sees
 *     p(i, j) = centre + (i + 1/2 - width / 2) pixel right + (height / 2 - j - 1/2) pixel up
 * in parallel projection along -eye, in perspective from `place`, which is `distance` eye before
 * `centre`. */
#ifndef CVOL_RENDER_VIEW_VIEW_H
#define CVOL_RENDER_VIEW_VIEW_H

#include "cvol/camera.h"

/* The planes of the clip, and one for parts too near to the eye. */
#define CVOL_VIEW_PLANES (CVOL_CLIP_PLANES + 1)
/* The faces of the clip: of its box, and its planes; and those of the volume. */
#define CVOL_VIEW_CUTS (CVOL_CLIP_PLANES + 12)

/* Blocks are evaluated on fewer points than samples only while a pixel of the picture spans at
 * least 1 / CVOL_COARSEST_PITCH of the points: with fewer, the picture is visibly softer than the
 * volume. */
#define CVOL_COARSEST_PITCH 0.7

typedef struct cvol_view {
    double right[3], up[3], eye[3]; /* orthonormal, right x up = eye (towards the viewer) */
    double centre[3], extent[3];    /* the middle of the picture; the box */
    int perspective;
    double place[3], distance; /* of the eye, in perspective */
    double ahead; /* else depths are measured from the plane at this distance before the centre, */
                  /* which touches the ball about the box */
    double pixel; /* world size of a pixel (at that distance) */
    double mean_spacing; /* the length for which opacity is given */
    int width, height;
    int first_row, all_rows; /* of the whole picture: see cvol_rows */
    double
        rays; /* for engine sheet: least number of ray lines and columns per line of the picture */
    /* In object order: rays lie this many pixels apart, at most one sample, and points up to this
     * many if pixels span more (plan.h). */
    double apart, coarsest;
    double step;         /* between samples along rays, in mean spacings; 0: the engine's default */
    int clipped;         /* lo, hi are not all the faces of the volume, or there are planes */
    double lo[3], hi[3]; /* the drawn box, in sample indices: an axis of one sample is */
                         /* one spacing thick */
    int planes;          /* and its part with plane . (x, y, z, 1) >= 0 for all, x y z in */
    double plane[CVOL_VIEW_PLANES][4]; /* sample indices, is drawn */
    /* The box of cvol_part in it; all of it without a part. */
    double own_lo[3], own_hi[3];
    /* Faces of the clip, the large faces of a slab, and those of cvol_view_add_face: cut . (x, y,
     * z, 1) is the depth behind one, and reaches 1 where the light of a cut ends (cvol_cut_fade).
     */
    int cuts;
    double cut[CVOL_VIEW_CUTS][4];
} cvol_view;

/* Gradients behind a cut are multiplied by this, for the least depth. Cut matter would be lit by
 * the noise within it; flat matter faces the eye. Linear, as gradients are between two slices. Not
 * 0: where a gradient is 0 there is none. */
static inline double cvol_cut_fade(double depth)
{
    return depth < 0.01 ? 0.01 : depth > 1 ? 1 : depth;
}

/* The same at a place, in sample indices. */
static inline double cvol_view_fade(const cvol_view *view, const double place[3])
{
    double depth = 1;
    for (int k = 0; k < view->cuts; k++) {
        const double *cut = view->cut[k];
        const double at = cut[0] * place[0] + cut[1] * place[1] + cut[2] * place[2] + cut[3];
        depth = at < depth ? at : depth;
    }
    return cvol_cut_fade(depth);
}

#endif
