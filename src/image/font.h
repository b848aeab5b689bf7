/* Text over pictures: letters made of strokes, at any size. */
#ifndef CVOL_IMAGE_FONT_H
#define CVOL_IMAGE_FONT_H

#include "image/ink.h"

/* The width of a text with capitals of `height` pixels. Letters are those of ASCII and, in UTF-8,
 * the micro and the degree sign; others leave a gap. */
double cvol_text_width(const char *text, double height);
/* Draws it from x on, with the baseline of capitals at y; the pen's width and halo are set from the
 * height. */
void cvol_text_draw(cvol_image *image, const char *text, double x, double y, double height,
                    const cvol_pen *pen);
/* Width and halo in pixels. */
cvol_pen cvol_text_pen(const cvol_pen *pen, double height);

#endif
