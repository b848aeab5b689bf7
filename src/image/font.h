/* Text over pictures, in the letters of the font Inter (third_party/inter). */
#ifndef CVOL_IMAGE_FONT_H
#define CVOL_IMAGE_FONT_H

#include "cvol/base.h"
#include "image/ink.h"

/* The font at one size. */
typedef struct cvol_font cvol_font;

/* Capitals get `height` pixels, rounded to a whole number, from 1 to 1024. */
int cvol_font_open(cvol_context *context, cvol_font **font, double height);
void cvol_font_free(cvol_font *font);

/* The width of a text in UTF-8, in pixels. The font has Latin and Greek letters and the signs of
 * units and mathematics; others become an empty box. */
double cvol_text_width(cvol_font *font, const char *text);
/* Draws it from x on, with the baseline at y, rounded to a whole number of pixels. It takes the
 * colours and opacities of the pen; the halo follows from the height. */
void cvol_text_draw(cvol_image *image, cvol_font *font, const char *text, double x, double y,
                    const cvol_pen *pen);

#endif
