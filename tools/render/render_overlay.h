/* Overlays of one picture: further volumes. Each is drawn on a grid of its own over the first one,
 * which may be coarser than that of the first (cvol_grid_coarsen). */
#ifndef CVOL_TOOLS_RENDER_OVERLAY_H
#define CVOL_TOOLS_RENDER_OVERLAY_H

#include "tools/render/render_picture.h"

typedef struct overlay {
    const char *path;
    double opacity, depth; /* --overlay-opacity and --overlay-depth */
    int is_labels;
    label_set *labels;    /* NULL: no labels, or their own values */
    cvol_volume *numbers; /* of the labels, on the overlay's grid; their shape is drawn */
    double overlap;       /* share of the volume that lies in the overlay */
    double share[3];   /* samples of the overlay's grid over those of the volume, along the axes */
    cvol_array *array; /* engine sheet */
    cvol_volume *volume; /* engine ray */
    uint8_t *mask;       /* engine ray: samples outside of the overlay; NULL: none */
    cvol_renderer *renderer;
    cvol_transfer *transfer;
    cvol_transfer *dense; /* for depths */
    double rescale[2];    /* a sample s means rescale[0] s + rescale[1] */
} overlay;

/* render_overlay_transfer.c: makes the transfer functions of an overlay, fitted to its own samples.
 * `density`: the spacing of the drawn samples over that of the volume. Exit status. */
int choose_overlay_transfer(cvol_context *context, overlay *o, const cvol_volume *volume,
                            const char *name, const char *window_text, double density);
/* render_blend.c: mixes pictures of overlays into that of the volume. */
void blend_overlays(cvol_image *image, const overlay *overlays, cvol_image *const *pictures,
                    int count);

#endif
