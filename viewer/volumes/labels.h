/* The labels of a volume: their shape, and their colours. */
#ifndef CVOL_VIEWER_VOLUMES_LABELS_H
#define CVOL_VIEWER_VOLUMES_LABELS_H

#include <jansson.h>

#include "viewer/volumes/shown_volume.h"

enum { LABELS_SHOWN_MAX = 255 };

struct shown_labels {
    cvol_volume *numbers; /* uint8: 1 to count; 0: no label */
    cvol_array *shape;    /* cvol_labels_create_shape */
    size_t count;
    int values[LABELS_SHOWN_MAX]; /* rising */
    double colours[3 * LABELS_SHOWN_MAX];
};

/* Finds the labels of a volume that has been read; *out is NULL if its samples are no labels, are
 * not exact, are of two values only, or are more labels than have their own colours. */
int labels_find(cvol_context *context, shown_labels **out, const shown_volume *v);
void labels_free(shown_labels *labels);
/* [{"value", "name" or null, "colour"}, ...], or null. */
json_t *labels_describe(const shown_volume *v);
/* The number at a place in samples: the one that has the largest part of the interpolated samples
 * there, as in the colours of a picture; 0: none. */
int labels_number_at(const cvol_volume *numbers, const double place[3]);
/* The label of that number. */
int labels_at(const shown_volume *v, const double place[3]);
/* The colour of a sample, as bytes; black where it is no label. */
void labels_colour(uint8_t rgb[3], const shown_labels *labels, double sample);
/* The name of a label; NULL: unknown. */
const char *labels_name(const shown_volume *v, double value);
/* Draws the labels by a renderer of their shape, which has this transfer function. */
int labels_draw(cvol_context *context, const shown_labels *labels, cvol_renderer *renderer,
                cvol_image *image, const cvol_render_options *options,
                const cvol_transfer *transfer);

#endif
