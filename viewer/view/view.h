/* Views: VIEW of the interface as options of a renderer. */
#ifndef CVOL_VIEWER_VIEW_VIEW_H
#define CVOL_VIEWER_VIEW_VIEW_H

#include "viewer/base/fields.h"
#include "viewer/volumes/overlays.h"
#include "viewer/volumes/volume_renderers.h"
#include "viewer/volumes/volumes.h"

enum {
    VIEW_SIZE_MAX = 8192,
    VIEW_PIXELS_MAX = 1 << 25,
    VIEW_POINTS_MAX = 1024,
    VIEW_CHANNELS_MAX = 16
};

/* The transfer function of a component of RGB samples, by name. */
#define VIEW_COMPONENT "component"

typedef struct view view;
struct view {
    shown_volume *volume; /* held; of several times: the first, until view_open */
    int time;             /* of the volume */
    cvol_render_options options;
    int mirror;
    char transfer_name[32]; /* "": points were given */
    cvol_transfer_point *points;
    size_t point_count;
    double opacity_scale;
    int has_surface_value;
    view *channels; /* [channel_count]: drawn in place of the volume, and added; 0: none */
    int channel_count;
    int has_colour; /* of a channel, like the next one */
    double colour[3];
    overlay_choice overlays[OVERLAYS_MAX]; /* [overlay_count] */
    int overlay_count;
};

/* Reads the fields of a view. 0, or a status of HTTP, with the message in f->error. */
int view_take(view *out, volumes *all, fields *f);
/* Call it before the first picture, on a thread that may wait: `volume` becomes the one at the time
 * of the view. Returns a code of the library. */
int view_open(cvol_context *context, view *v);
/* Makes a copy of a view that is not open, at another time, and opens it. The caller frees *out,
 * after an error too. Returns a code of the library. */
int view_open_at(cvol_context *context, view *out, const view *v, int time);
/* view_overlays.c: reads "overlays" of a view whose volume is known. */
void view_take_overlays(view *v, fields *f);
/* 1 if an overlay is drawn. */
int view_shows_overlays(const view *v);
/* Draws the volume of an open view by a renderer of it, and its overlays, into a picture of bytes.
 */
int view_draw(cvol_context *context, const view *v, idle_renderer *renderer, cvol_image *image,
              const cvol_render_options *options);
/* Frees volume and points. */
void view_free(view *v);
/* Makes the transfer function of the view, which the caller frees, and a hash of its points. The
 * volume must be ready. */
int view_make_transfer(cvol_context *context, cvol_transfer **out, uint64_t *hash, const view *v);
/* Replaces the transfer function by its points for the volume. */
int view_fix_colours(cvol_context *context, view *v);
/* 1 if the view shows labels: in mode composite, with the automatic transfer function. */
int view_shows_labels(const view *v);
/* Sets the transfer function of the view in the renderer (mode composite), or that of labels in a
 * renderer of labels. */
int view_set_transfer(cvol_context *context, idle_renderer *renderer, const view *v);

#endif
