/* Volumes as JSON for the interface. */
#include <math.h>
#include <stdio.h>

#include "viewer/base/answer.h"
#include "viewer/volumes/labels.h"
#include "viewer/volumes/overlays.h"
#include "viewer/volumes/volumes.h"

static json_t *triple(const double v[3])
{
    return json_pack("[f, f, f]", v[0], v[1], v[2]);
}

/* The six named views, and whether they must be mirrored. */
static json_t *describe_views(const cvol_grid *grid, int *mirrored)
{
    static const char *const names[] = {"front", "back", "left", "right", "top", "bottom"};
    json_t *views = json_object();
    cvol_context *context = cvol_context_create();
    for (size_t i = 0; context && i < sizeof names / sizeof *names; i++) {
        cvol_camera camera = cvol_render_options_defaults().camera;
        if (!cvol_camera_set_view(context, &camera, mirrored, names[i], grid, 0))
            json_object_set_new(views, names[i],
                                json_pack("{s:f, s:f, s:f}", "azimuth", camera.azimuth_deg,
                                          "elevation", camera.elevation_deg, "roll",
                                          camera.roll_deg));
    }
    cvol_context_free(context);
    return views;
}

enum { TIME_VALUES_MOST = 65536 }; /* more are left out */

static json_t *describe_times(const shown_volume *v)
{
    if (!v->time_values || v->times > TIME_VALUES_MOST)
        return json_null();
    json_t *values = json_array();
    for (int t = 0; t < v->times; t++)
        json_array_append_new(values, answer_number(v->time_values[t]));
    return values;
}

static json_t *describe_channel(const shown_volume *v)
{
    const viewer_channel *c = &v->channel;
    char first[VOLUME_ID_BYTES];
    if (!c->count)
        return json_null();
    snprintf(first, sizeof first, "%d", c->first);
    return json_pack("{s:s, s:i, s:i, s:o, s:o, s:b}", "first", first, "number", c->number, "count",
                     c->count, "name", answer_text(c->name[0] ? c->name : NULL), "colour",
                     triple(c->rgb), "component", c->is_component);
}

static int has_values(const cvol_histogram *histogram)
{
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++)
        if (histogram->bins[i])
            return 1;
    return 0;
}

/* 0 without memory. */
static int describe_ready(json_t *object, const shown_volume *v)
{
    const cvol_grid *g = &v->grid;
    int mirrored = 0;
    const double ratio = (double)v->raw_bytes / (double)v->compressed_bytes;
    json_t *more = json_pack(
        "{s:[I,I,I], s:o, s:o, s:s, s:f, s:f, s:f, s:f, s:I, s:I, s:o, s:o, s:b, s:o, s:o}", "dims",
        (json_int_t)g->dims[0], (json_int_t)g->dims[1], (json_int_t)g->dims[2], "spacing",
        triple(g->spacing), "unit", answer_text(g->unit), "type", cvol_type_name(g->type), "min",
        v->histogram.min, "max", v->histogram.max, "value_scale", g->value_scale, "value_offset",
        g->value_offset, "raw_bytes", (json_int_t)v->raw_bytes, "compressed_bytes",
        (json_int_t)v->compressed_bytes, "ratio", answer_number(ratio), "psnr_db",
        answer_number(v->psnr_db), "exact", isinf(v->psnr_db) && v->psnr_db > 0, "max_error",
        answer_number(v->max_error), "rescale",
        fabs(v->rescale[0]) > 0 ? json_pack("[f, f]", v->rescale[0], v->rescale[1]) : json_null());
    const int failed = json_object_update(object, more);
    json_decref(more);
    if (failed)
        return 0;
    json_object_set_new(object, "home",
                        json_pack("{s:f, s:f, s:f, s:o, s:[f, f], s:b}", "azimuth",
                                  v->home.azimuth_deg, "elevation", v->home.elevation_deg, "roll",
                                  v->home.roll_deg, "look_at", triple(v->home.look_at), "size",
                                  v->home_size[0], v->home_size[1], "lit", v->home_lit));
    if (v->parent)
        json_object_set_new(object, "time", json_integer(v->copied_time));
    json_object_set_new(object, "times", json_integer(v->times));
    json_object_set_new(object, "time_values", describe_times(v));
    json_object_set_new(object, "time_unit", answer_text(v->time_unit));
    json_object_set_new(object, "labels", labels_describe(v));
    json_object_set_new(object, "overlays", overlays_describe(v));
    json_object_set_new(object, "views", describe_views(g, &mirrored));
    json_object_set_new(object, "mirrored", json_boolean(mirrored));
    json_object_set_new(object, "measured", json_boolean(v->measured));
    json_object_set_new(object, "whole_level", json_integer(v->level));
    json_object_set_new(object, "whole", json_boolean(!v->cut));
    json_object_set_new(object, "residual_missing", json_boolean(v->residual_missing));
    json_object_set_new(object, "has_values", json_boolean(has_values(&v->histogram)));
    json_object_set_new(object, "patient", json_boolean(g->space != CVOL_SPACE_UNKNOWN));
    return 1;
}

json_t *volume_describe(shown_volume *v)
{
    static const char *const names[] = {"reading", "compressing", "ready", "failed"};
    const volume_look look = volume_look_at(v);
    json_t *object = json_pack("{s:s, s:o, s:o, s:s, s:{s:s, s:f}, s:o, s:o}", "id", v->id, "name",
                               answer_text(v->name), "path", answer_text(v->path), "state",
                               names[look.state], "doing", "what", look.doing, "fraction",
                               look.fraction, "error", answer_text(look.error), "parent",
                               answer_text(v->parent ? v->parent->id : NULL));
    if (object)
        json_object_set_new(object, "channel", describe_channel(v));
    if (object && look.state == VOLUME_READY && !describe_ready(object, v)) {
        json_decref(object);
        return NULL;
    }
    return object;
}

json_t *volumes_describe(volumes *all)
{
    shown_volume *held[VOLUMES_MAX + COPIES_MAX];
    json_t *list = json_array();
    const int count = volumes_hold_all(all, held);
    for (int i = 0; i < count; i++) {
        json_array_append_new(list, volume_describe(held[i]));
        volume_release(held[i]);
    }
    return json_pack("{s:o}", "volumes", list);
}
