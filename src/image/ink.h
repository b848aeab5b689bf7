/* Drawing over pictures of floats: strokes with round ends, smooth at their edges, within a halo.
 */
#ifndef CVOL_IMAGE_INK_H
#define CVOL_IMAGE_INK_H

#include "cvol/image.h"

typedef struct cvol_segment {
    float x0, y0, x1, y1; /* pixels; (0, 0) is the upper left corner, y runs down */
} cvol_segment;

/* The properties of a stroke. */
typedef struct cvol_pen {
    float width, halo;       /* pixels: of the stroke, and around it */
    float rgb[3], ground[3]; /* of the stroke, and of the halo */
    float opacity, ground_opacity;
} cvol_pen;

/* The halo of all segments, which lies below everything that is drawn later. */
void cvol_ink_halo(cvol_image *image, const cvol_segment *segments, int count, const cvol_pen *pen);
void cvol_ink_stroke(cvol_image *image, const cvol_segment *segments, int count,
                     const cvol_pen *pen);
/* Covers pixels by shares, 0 to 255, from pixel x, y on; what lies outside the picture is left out.
 */
void cvol_ink_mask(cvol_image *image, const unsigned char *shares, int width, int height, int x,
                   int y, const cvol_pen *pen);
/* A rectangle of one colour; its edges may lie within pixels. */
void cvol_ink_box(cvol_image *image, double x0, double y0, double x1, double y1, const float rgb[3],
                  float opacity);

#endif
