/* Overlays of one picture (tools/overlay). */
#ifndef CVOL_TOOLS_RENDER_OVERLAY_H
#define CVOL_TOOLS_RENDER_OVERLAY_H

#include "tools/render/render_picture.h"

typedef struct scene_overlay {
    overlay_source source;
    overlay_look look;
    overlay fitted;
    cvol_transfer *file; /* --overlay-transfer of a file; NULL: none */
    label_set *labels;   /* NULL: no labels, or their own values */
    cvol_renderer *renderer;
    cvol_transfer *colours, *depths;
    double rescale[2]; /* a sample s means rescale[0] s + rescale[1] */
} scene_overlay;

#endif
