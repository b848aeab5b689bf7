/* The overlays of a volume: further volumes that are drawn over it (tools/overlay). */
#ifndef CVOL_VIEWER_VOLUMES_OVERLAYS_H
#define CVOL_VIEWER_VOLUMES_OVERLAYS_H

#include <jansson.h>

#include "viewer/volumes/shown_volume.h"

/* How a view shows an overlay. */
typedef struct overlay_choice {
    int on, has_window, has_chosen;
    char transfer[32]; /* a name; "": the one that was given, or the default */
    double opacity, depth;
    double window[2];                   /* sample values */
    uint8_t chosen[OVERLAY_LABELS_MAX]; /* of has_chosen: 1 for each label that is drawn */
} overlay_choice;

/* Puts all overlays on the grid of a volume that has been read. */
int overlays_fit(cvol_context *context, shown_volume *v, const viewer_options *options);
void overlays_free(shown_volume *v);
/* The volume whose overlays are those of `v`: of a time or of a copy another one. */
shown_volume *overlays_owner(const shown_volume *v);
/* Overlay i as it was given. */
const viewer_overlay *overlays_given(const shown_volume *v, int i);
/* How overlay i is shown at first. */
overlay_choice overlays_first_choice(const shown_volume *v, int i);
/* 1 if the choice draws something. */
int overlays_is_drawn(const overlay_choice *choice, const viewer_overlay *given);
/* The transfer functions of overlay i by a choice; the caller frees them. density: the spacing of
 * samples over that of the volume, for which the opacities are. */
int overlays_create_transfers(cvol_context *context, cvol_transfer **colours,
                              cvol_transfer **depths, const shown_volume *v, int i,
                              const overlay_choice *choice, double density);
/* Overlay i on the grid of the volume, with the chosen labels. *out stays valid until
 * overlays_release. */
typedef struct held_overlay held_overlay;
int overlays_hold(cvol_context *context, held_overlay **held, const overlay **out,
                  const shown_volume *v, int i, const overlay_choice *choice);
void overlays_release(const shown_volume *v, held_overlay *held);
/* Draws overlays into a picture of floats that shows the volume, with depths if its mode has them.
 */
int overlays_draw(cvol_context *context, const shown_volume *v, const overlay_choice *choices,
                  int count, cvol_image *image, const cvol_render_options *options);
/* Replaces the depth of a pixel by that of the labels of overlays which are in front of it, half a
 * sample below their surface. */
int overlays_find_depth(cvol_context *context, double *depth, const shown_volume *v,
                        const overlay_choice *choices, int count,
                        const cvol_render_options *options, size_t pixel);
/* Bytes of the overlays of a volume with all labels; of times and copies 0. */
uint64_t overlays_resident_bytes(const shown_volume *v);
/* overlay_slices.c: paints overlays over a slice across an axis: a picture of bytes whose rows have
 * the samples of the volume, x or y first; is_up: the last row is the first one of the picture. */
int overlays_paint_slice(cvol_context *context, const shown_volume *v,
                         const overlay_choice *choices, int count, cvol_image *image, int axis,
                         size_t index, int is_up);
/* overlay_values.c: [{"value", "label"}, ...] of each overlay at a place in samples of the volume;
 * null: none. on_surface: the place is on what a picture shows, so labels around it count, too. */
json_t *overlays_describe_place(cvol_context *context, const shown_volume *v, const double place[3],
                                int on_surface);
/* [{"name", "path", "labels", ...}, ...] */
json_t *overlays_describe(const shown_volume *v);

#endif
