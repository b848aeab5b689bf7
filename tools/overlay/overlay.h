/* Overlays: further volumes in the picture of a volume, as PET over MRI. The command and the viewer
 * share these functions.
 *
 * An overlay is resampled to the axes and the box of the volume, with no more samples than it has
 * (cvol_grid_coarsen), and the same engine draws it, with the same camera and clip. Two pictures of
 * it are needed: its colours, and, from a denser transfer function, the depth at which its visible
 * part begins. overlay_blend mixes the pictures.
 *
 * Functions return a code of the library; the message names the file of the overlay. */
#ifndef CVOL_TOOLS_OVERLAY_OVERLAY_H
#define CVOL_TOOLS_OVERLAY_OVERLAY_H

#include "cvol/cvol.h"

enum {
    OVERLAYS_MAX = 4, /* of one picture */
    OVERLAY_LABELS_MAX = 255
};

/* A volume that can be drawn over others. */
typedef struct overlay_source {
    const char *path;
    cvol_volume *samples; /* values, of which NaN is none; or labels, or numbers of labels */
    int is_labels;
    int is_numbered; /* samples are the numbers 1 to `count` of labels that are drawn; 0: none */
    size_t count;
    double colours[3 * OVERLAY_LABELS_MAX]; /* of numbered labels */
    cvol_grid grid;                         /* of the samples, by overlay_measure; as the next */
    cvol_histogram histogram;               /* of samples that are not numbered */
    int has_one_value;                      /* 1: all of these have one value, and none lacks it */
} overlay_source;

/* Colours and strength of an overlay. */
typedef struct overlay_look {
    const char *transfer;       /* a name; NULL: hot, or a colour for each label */
    const cvol_transfer *given; /* instead of a name; NULL: none */
    int has_window;
    double window[2]; /* sample values over which the colours are spread */
    double opacity;   /* 0 to 1 */
    double depth; /* how deep behind the visible surface it shines through; below 0: the default */
} overlay_look;

/* An overlay on a grid over the box of a volume. */
typedef struct overlay {
    const overlay_source *of;
    cvol_array *array;    /* engine sheet */
    cvol_volume *volume;  /* engine ray */
    uint8_t *mask;        /* engine ray: samples without a value; NULL: none */
    cvol_volume *numbers; /* of the labels, whose shape is drawn; NULL: other samples are drawn */
    double share[3];      /* samples of its grid over those of the volume, along the axes */
    double density;       /* the spacing of its samples over that of the volume */
    double overlap;       /* the share of the volume that lies in the overlay */
} overlay;

/* Sets grid, histogram and has_one_value of a source. */
int overlay_measure(cvol_context *context, overlay_source *source);
/* fit.c: checks that the overlay has a place in common with a volume, which `name` names. */
int overlay_check(cvol_context *context, const overlay_source *source, const cvol_grid *grid,
                  const char *name);
/* Puts the overlay on the grid of a volume, for engine sheet or ray. chosen: 1 for each numbered
 * label that is drawn, or NULL for all. The source must outlive it; its samples need not. The
 * caller frees the parts of *out by overlay_free, after an error too. */
int overlay_fit(cvol_context *context, overlay *out, const overlay_source *source,
                const cvol_grid *grid, const char *name, cvol_engine engine, const uint8_t *chosen);
void overlay_free(overlay *o);
/* A renderer of a fitted overlay. */
int overlay_create_renderer(cvol_context *context, cvol_renderer **out, const overlay *o,
                            cvol_engine engine);
/* The depth of a look without one: a quarter of the diagonal of the volume. */
double overlay_default_depth(const cvol_grid *grid);

/* transfer.c: 1 if all samples have one value, to which no colours can be fitted: nothing is drawn.
 */
int overlay_is_blank(const overlay_source *source, const overlay_look *look);
/* Makes the transfer functions of an overlay, fitted to its own samples: colours, and a
 * denser one for depths. `density`: that of the fitted overlay. */
int overlay_create_transfers(cvol_context *context, cvol_transfer **colours, cvol_transfer **depths,
                             const overlay_source *source, const overlay_look *look,
                             double density);
/* The window in sample values of centre and width in values after the rescale of the file. 1 if its
 * width is finite and above 0. */
int overlay_get_window(double window[2], const overlay_source *source, const double given[2]);
/* The scale and offset of the values of the file. */
void overlay_get_rescale(double rescale[2], const overlay_source *source);

/* draw.c: draws the shape of numbered labels by a renderer that has the transfer function of masks,
 * into a black picture of floats, in `count` colours. transfer: what the renderer has,
 * or NULL if that is opaque. */
int overlay_draw_labels(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                        const cvol_render_options *options, const cvol_volume *numbers,
                        const double *colours, size_t count, const cvol_transfer *transfer);
/* Draws the colours of an overlay into a black picture of floats; the renderer has their transfer
 * function. options: those of the volume. Numbered labels get depths, unless the volume has none.
 */
int overlay_draw(cvol_context *context, const overlay *o, cvol_renderer *renderer,
                 cvol_image *image, const cvol_render_options *options);
/* 1 if depths need a picture of their own. */
int overlay_needs_depths(const overlay *o, cvol_mode mode);
/* Adds depths to that picture; the renderer has the denser transfer function. */
int overlay_add_depths(cvol_context *context, const overlay *o, cvol_renderer *renderer,
                       cvol_image *image, const cvol_render_options *options);
/* 1 if a picture of the mode has depths: others show values as grey levels. */
int overlay_mode_has_depth(cvol_mode mode);

/* blend.c: a picture of an overlay, and its strength. */
typedef struct overlay_layer {
    cvol_image *picture;
    double opacity, depth;
} overlay_layer;
/* Mixes pictures of overlays into that of the volume. */
void overlay_blend(cvol_image *image, const overlay_layer *layers, int count);

#endif
