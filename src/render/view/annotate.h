/* The parts of an annotation. */
#ifndef CVOL_RENDER_VIEW_ANNOTATE_H
#define CVOL_RENDER_VIEW_ANNOTATE_H

#include "cvol/annotate.h"
#include "image/font.h"
#include "render/view/camera.h"

/* Position and style. */
typedef struct cvol_sketch {
    cvol_image *image;
    const cvol_annotation *of;
    cvol_view view;
    cvol_pen pen; /* for lines, and the colours of letters */
    cvol_font *font;
    double letter, margin; /* pixels: the height of capitals, and room at the edges */
    int grey, is_bright;   /* no colours; the background is bright */
} cvol_sketch;

void cvol_sketch_scale(const cvol_sketch *sketch);
void cvol_sketch_axes(const cvol_sketch *sketch);
void cvol_sketch_values(const cvol_sketch *sketch);

#endif
