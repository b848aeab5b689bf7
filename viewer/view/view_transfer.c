/* The transfer functions of views. */
#include "viewer/view/view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int make_named(cvol_context *context, cvol_transfer **out, const view *v)
{
    const shown_volume *volume = volume_series(v->volume);
    /* Without a known rescale, samples count as Hounsfield units: the user chose the name. */
    const double as_stored[2] = {1, 0};
    double range[2];
    if (v->has_colour && !strcmp(v->transfer_name, VIEW_COMPONENT)) {
        cvol_component_get_range(range, volume->grid.type);
        return cvol_transfer_create_component(context, out, &volume->histogram, range, v->colour);
    }
    if (!strcmp(v->transfer_name, "auto"))
        return cvol_transfer_create_auto(context, out, NULL, NULL, &volume->histogram,
                                         &volume->grid, volume_is_exact(volume));
    if (cvol_transfer_is_ct(v->transfer_name))
        return cvol_transfer_create_ct(context, out, v->transfer_name,
                                       fabs(volume->rescale[0]) > 0 ? volume->rescale : as_stored);
    return cvol_transfer_create_named(context, out, v->transfer_name, &volume->histogram);
}

/* Gives the transfer function of a channel its colour; a component has it. */
static int tint(cvol_context *context, cvol_transfer **transfer, const view *v)
{
    cvol_transfer *tinted;
    if (!strcmp(v->transfer_name, VIEW_COMPONENT))
        return CVOL_OK;
    const int code = cvol_transfer_create_tinted(context, &tinted, *transfer, v->colour);
    cvol_transfer_free(*transfer);
    *transfer = tinted;
    return code;
}

int view_make_transfer(cvol_context *context, cvol_transfer **out, uint64_t *hash, const view *v)
{
    cvol_transfer *given = NULL;
    int code = v->transfer_name[0]
                   ? make_named(context, &given, v)
                   : cvol_transfer_create(context, &given, v->points, v->point_count);
    if (!code)
        code = cvol_transfer_create_adjusted(context, out, given, NULL, v->opacity_scale);
    cvol_transfer_free(given);
    if (!code && v->has_colour)
        code = tint(context, out, v);
    if (!code)
        *hash = transfer_hash(*out);
    return code;
}

int view_fix_colours(cvol_context *context, view *v)
{
    cvol_transfer *transfer = NULL;
    uint64_t hash;
    const int code = view_make_transfer(context, &transfer, &hash, v);
    if (code)
        return code;
    const size_t count = cvol_transfer_count(transfer);
    cvol_transfer_point *points = calloc(count, sizeof *points);
    for (size_t i = 0; i < count && points; i++)
        points[i] = cvol_transfer_point_at(transfer, i);
    cvol_transfer_free(transfer);
    if (!points)
        return CVOL_ERROR_MEMORY;
    free(v->points);
    v->points = points;
    v->point_count = count;
    v->transfer_name[0] = 0;
    v->opacity_scale = 1;
    return CVOL_OK;
}

int view_shows_labels(const view *v)
{
    return v->volume->labels && !v->has_colour && v->options.mode == CVOL_MODE_COMPOSITE &&
           !strcmp(v->transfer_name, "auto");
}

static int set_labels(cvol_context *context, idle_renderer *renderer, const view *v)
{
    cvol_transfer *opaque = NULL, *transfer = NULL;
    int code = cvol_labels_create_mask_transfer(context, &opaque);
    if (!code)
        code = cvol_transfer_create_adjusted(context, &transfer, opaque, NULL, v->opacity_scale);
    cvol_transfer_free(opaque);
    if (!code)
        code = renderer_set_transfer(context, renderer, transfer);
    if (code) {
        cvol_transfer_free(transfer);
        return code;
    }
    cvol_transfer_free(renderer->shown);
    renderer->shown = transfer;
    return code;
}

int view_set_transfer(cvol_context *context, idle_renderer *renderer, const view *v)
{
    cvol_transfer *transfer = NULL;
    uint64_t hash;
    if (v->options.mode != CVOL_MODE_COMPOSITE)
        return CVOL_OK;
    if (renderer->labels)
        return set_labels(context, renderer, v);
    int code = view_make_transfer(context, &transfer, &hash, v);
    if (!code)
        code = renderer_set_transfer(context, renderer, transfer);
    cvol_transfer_free(transfer);
    return code;
}
