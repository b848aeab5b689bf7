/* Views. */
#include "viewer/view/view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/words/words.h"
#include "viewer/volumes/times.h"

/* Reads a word of the table; returns its value, or `usual` without the field. */
static int take_word(fields *f, const char *name, const word_table *table, int usual)
{
    char word[16], list[WORD_LIST];
    int value = usual;
    snprintf(word, sizeof word, "%s", word_of(table, usual));
    take_text(f, name, word, sizeof word);
    if (!find_word(&value, table, word))
        fields_fail(f, "%s%s is '%s', must be %s", f->within, name, word,
                    list_words(list, table, ", ", " or "));
    return value;
}

static void take_camera(view *v, fields *f)
{
    fields inner = take_object(f, "camera", "view.camera.");
    cvol_camera *camera = &v->options.camera;
    take_number(&inner, "azimuth", &camera->azimuth_deg, -1e6, 1e6);
    take_number(&inner, "elevation", &camera->elevation_deg, -1e6, 1e6);
    take_number(&inner, "roll", &camera->roll_deg, -1e6, 1e6);
    take_number(&inner, "zoom", &camera->zoom, 1e-3, 1e4);
    take_number(&inner, "fov", &camera->fov_deg, 0, 150);
    if (camera->fov_deg > 0 && camera->fov_deg < 1)
        fields_fail(&inner, "view.camera.fov is %g, must be 0 (parallel) or 1 to 150",
                    camera->fov_deg);
    take_numbers(&inner, "look_at", camera->look_at, 3);
    fields_end(&inner);
}

static void take_light(view *v, fields *f)
{
    fields inner = take_object(f, "light", "view.light.");
    cvol_shading *light = &v->options.shading;
    cvol_illumination *more = &v->options.illumination;
    take_bool(&inner, "on", &light->on);
    take_numbers(&inner, "direction", light->light, 3);
    take_number(&inner, "ambient", &light->ambient, 0, 10);
    take_number(&inner, "diffuse", &light->diffuse, 0, 10);
    take_number(&inner, "specular", &light->specular, 0, 10);
    take_integer(&inner, "shininess", &light->shininess, 1, 256);
    take_number(&inner, "gradient_opacity", &light->gradient_opacity, 0, 1e30);
    take_number(&inner, "fill", &more->fill, 0, 10);
    take_number(&inner, "occlusion", &more->occlusion, 0, 1);
    take_number(&inner, "shadows", &more->shadows, 0, 1);
    take_integer(&inner, "samples", &more->samples, 0, 65536);
    take_bool(&inner, "in_view", &more->in_view);
    take_bool(&inner, "keeps_brightness", &more->keeps_brightness);
    fields_end(&inner);
}

static int within_unit(const double *rgb)
{
    for (int c = 0; c < 3; c++)
        if (!(rgb[c] >= 0 && rgb[c] <= 1))
            return 0;
    return 1;
}

static void take_surface(view *v, fields *f)
{
    fields inner = take_object(f, "surface", "view.surface.");
    cvol_surface *surface = &v->options.surface;
    v->has_surface_value = take_number(&inner, "value", &surface->value, -1e300, 1e300);
    take_numbers(&inner, "colour", surface->colour, 3);
    if (!within_unit(surface->colour))
        fields_fail(&inner, "view.surface.colour must be three numbers within 0 and 1");
    fields_end(&inner);
}

/* [x0, x1, y0, y1, z0, z1]; null: no clipping at this face. */
static void take_box(cvol_clip *clip, fields *f)
{
    json_t *box = take_any(f, "box");
    int good = !box || json_is_null(box) || (json_is_array(box) && json_array_size(box) == 6);
    for (int i = 0; good && json_is_array(box) && i < 6; i++) {
        const json_t *face = json_array_get(box, (size_t)i);
        double *side = i % 2 ? &clip->to[i / 2] : &clip->from[i / 2];
        good = json_is_null(face) || (json_is_number(face) && isfinite(json_number_value(face)));
        *side = json_is_number(face) ? json_number_value(face) : i % 2 ? 1e30 : -1e30;
        if (json_is_number(face))
            clip->axes |= 1 << (i / 2);
    }
    if (!good)
        fields_fail(f, "%sbox must be six numbers or nulls: x0, x1, y0, y1, z0, z1", f->within);
    json_decref(box);
}

static void take_planes(cvol_clip *clip, fields *f)
{
    json_t *planes = take_any(f, "planes");
    if (planes && (!json_is_array(planes) || json_array_size(planes) > CVOL_CLIP_PLANES)) {
        fields_fail(f, "%splanes must be at most %d of [nx, ny, nz, d]", f->within,
                    CVOL_CLIP_PLANES);
        json_decref(planes);
        return;
    }
    for (size_t k = 0; planes && k < json_array_size(planes); k++) {
        const json_t *plane = json_array_get(planes, k);
        int good = json_is_array(plane) && json_array_size(plane) == 4;
        for (size_t i = 0; good && i < 4; i++) {
            const json_t *number = json_array_get(plane, i);
            good = json_is_number(number) && isfinite(json_number_value(number));
            clip->plane[k][i] = json_number_value(number);
        }
        if (!good)
            fields_fail(f, "%splanes: number %zu must be four numbers, nx, ny, nz, d", f->within,
                        k);
        clip->planes = (int)k + 1;
    }
    json_decref(planes);
}

static void take_clip(view *v, fields *f)
{
    fields inner = take_object(f, "clip", "view.clip.");
    take_box(&v->options.clip, &inner);
    take_planes(&v->options.clip, &inner);
    fields_end(&inner);
}

static void take_points(view *v, fields *f, const json_t *points)
{
    const size_t count = json_array_size(points);
    if (count < 1 || count > VIEW_POINTS_MAX) {
        fields_fail(f, "%stransfer has %zu points, must have 1 to %d", f->within, count,
                    VIEW_POINTS_MAX);
        return;
    }
    v->points = calloc(count, sizeof *v->points);
    if (!v->points) {
        fields_fail(f, "not enough memory for a transfer function");
        return;
    }
    v->point_count = count;
    for (size_t i = 0; i < count; i++) {
        const json_t *point = json_array_get(points, i);
        double p[5] = {0};
        int good = json_is_array(point) && json_array_size(point) == 5;
        for (size_t k = 0; good && k < 5; k++) {
            const json_t *number = json_array_get(point, k);
            p[k] = json_number_value(number);
            good = json_is_number(number) && isfinite(p[k]) && (!k || (p[k] >= 0 && p[k] <= 1));
        }
        if (!good)
            fields_fail(f,
                        "%stransfer: point %zu must be [value, r, g, b, opacity], the last four "
                        "within 0 and 1",
                        f->within, i);
        v->points[i] = (cvol_transfer_point){p[0], p[1], p[2], p[3], p[4]};
    }
}

static void take_transfer(view *v, fields *f)
{
    json_t *transfer = take_any(f, "transfer");
    snprintf(v->transfer_name, sizeof v->transfer_name, "auto");
    if (json_is_array(transfer)) {
        v->transfer_name[0] = 0;
        take_points(v, f, transfer);
    } else if (transfer && (!json_is_string(transfer) || !json_string_length(transfer) ||
                            json_string_length(transfer) >= sizeof v->transfer_name)) {
        fields_fail(f, "%stransfer must be a name or points", f->within);
    } else if (transfer) {
        snprintf(v->transfer_name, sizeof v->transfer_name, "%s", json_string_value(transfer));
    }
    json_decref(transfer);
}

static void take_window(view *v, fields *f)
{
    json_t *window = f->object ? json_object_get(f->object, "window") : NULL;
    if (json_is_null(window)) {
        json_object_del(f->object, "window");
        return;
    }
    if (take_numbers(f, "window", v->options.window, 2) && fields_ok(f) &&
        !(v->options.window[1] > v->options.window[0]))
        fields_fail(f, "%swindow: the second value must be larger", f->within);
}

/* 0, 404 or 409. */
static int take_volume(view *v, volumes *all, fields *f)
{
    char id[VOLUME_ID_BYTES] = "";
    if (!take_text(f, "volume", id, sizeof id))
        fields_fail(f, "%svolume is missing: give its id", f->within);
    if (!fields_ok(f))
        return 400;
    v->volume = volumes_hold(all, id);
    if (!v->volume)
        fields_fail(f, "%svolume is '%s': there is no such volume", f->within, id);
    else if (!volume_is_ready(v->volume)) {
        char why[UNREADY_BYTES];
        volume_say_unready(why, sizeof why, v->volume, id);
        fields_fail(f, "%s", why);
    }
    return fields_ok(f) ? 0 : v->volume ? 409 : 404;
}

/* ---- channels ---------------------------------------------------------------------------------
 */

/* 1 if the volume of a channel exists and is not ready yet. */
static int is_awaited(volumes *all, const json_t *channel)
{
    const char *id = json_string_value(json_object_get(channel, "volume"));
    shown_volume *v = id ? volumes_hold(all, id) : NULL;
    const int awaited = v && !volume_is_ready(v);
    volume_release(v);
    return awaited;
}

/* Reads one channel, which has the settings of the view; 0, or a status. */
static int take_channel(view *out, const view *of, volumes *all, fields *f)
{
    const int has_transfer = json_object_get(f->object, "transfer") != NULL;
    *out = *of;
    out->volume = NULL;
    out->points = NULL;
    out->channels = NULL;
    out->channel_count = 0;
    out->overlay_count = 0;
    out->has_colour = 1;
    out->opacity_scale = 1;
    memset(out->options.window, 0, sizeof out->options.window);
    for (int k = 0; k < 3; k++)
        out->colour[k] = 1;
    const int status = take_volume(out, all, f);
    if (status)
        return status;
    take_transfer(out, f);
    if (!has_transfer)
        snprintf(out->transfer_name, sizeof out->transfer_name, "microscopy");
    take_numbers(f, "colour", out->colour, 3);
    if (!within_unit(out->colour))
        fields_fail(f, "%scolour must be three numbers within 0 and 1", f->within);
    take_number(f, "opacity_scale", &out->opacity_scale, 0, 1e6);
    take_window(out, f);
    fields_end(f);
    if (memcmp(out->volume->grid.dims, of->volume->grid.dims, sizeof of->volume->grid.dims) ||
        out->volume->times != of->volume->times)
        fields_fail(f, "%svolume is '%s': the channels must have the shape and the times of '%s'",
                    f->within, out->volume->id, of->volume->id);
    double *window = out->options.window;
    if (!(window[0] < window[1]) && !strcmp(out->transfer_name, VIEW_COMPONENT))
        cvol_component_get_range(window, out->volume->grid.type);
    else if (!(window[0] < window[1]))
        cvol_histogram_get_window(window, &out->volume->histogram);
    return fields_ok(f) ? 0 : 400;
}

/* 0, or a status. */
static int take_channels(view *v, volumes *all, fields *f)
{
    json_t *list = take_any(f, "channels");
    const size_t count = json_array_size(list);
    int status = 0;
    if (!list || json_is_null(list)) {
        json_decref(list);
        return 0;
    }
    if (count < 1 || count > VIEW_CHANNELS_MAX)
        fields_fail(f, "%schannels must be a list of 1 to %d channels", f->within,
                    VIEW_CHANNELS_MAX);
    else if (v->options.mode == CVOL_MODE_ISO || v->options.mode == CVOL_MODE_MIN)
        fields_fail(f, "%schannels needs mode composite, mip or xray", f->within);
    v->channels = fields_ok(f) ? calloc(count, sizeof *v->channels) : NULL;
    for (size_t i = 0; v->channels && i < count && !status; i++) {
        char within[64];
        snprintf(within, sizeof within, "%schannels[%zu].", f->within, i);
        fields inner = {json_array_get(list, i), NULL, within, f->error, f->error_bytes};
        if (!json_is_object(inner.object))
            fields_fail(f, "%schannels[%zu] must be an object", f->within, i);
        if (is_awaited(all, inner.object))
            continue;
        view *channel = &v->channels[v->channel_count++];
        status = fields_ok(f) ? take_channel(channel, v, all, &inner) : 400;
    }
    if (v->channels && !status && fields_ok(f) && !v->channel_count) {
        fields_fail(f, "%schannels: none of them is ready", f->within);
        status = 409;
    }
    json_decref(list);
    return status ? status : fields_ok(f) ? 0 : 400;
}

int view_take(view *out, volumes *all, fields *f)
{
    *out = (view){.options = cvol_render_options_defaults(), .opacity_scale = 1};
    const int status = take_volume(out, all, f);
    if (status)
        return status;
    cvol_render_options *options = &out->options;
    options->level = out->volume->level;
    take_integer(f, "time", &out->time, 0, out->volume->times - 1);
    take_integer(f, "width", &options->width, 1, VIEW_SIZE_MAX);
    take_integer(f, "height", &options->height, 1, VIEW_SIZE_MAX);
    if ((size_t)options->width * (size_t)options->height > VIEW_PIXELS_MAX)
        fields_fail(f, "%swidth and height are %d and %d, must have at most %d pixels together",
                    f->within, options->width, options->height, VIEW_PIXELS_MAX);
    options->mode = (cvol_mode)take_word(f, "mode", &mode_words, CVOL_MODE_COMPOSITE);
    take_camera(out, f);
    take_bool(f, "mirror", &out->mirror);
    take_transfer(out, f);
    take_number(f, "opacity_scale", &out->opacity_scale, 0, 1e6);
    take_window(out, f);
    take_light(out, f);
    if (options->illumination.in_view && out->mirror)
        options->illumination.in_view = -1;
    take_surface(out, f);
    take_clip(out, f);
    take_numbers(f, "background", options->background, 3);
    if (!within_unit(options->background))
        fields_fail(f, "%sbackground must be three numbers within 0 and 1", f->within);
    take_number(f, "step", &options->step_voxels, 0, 64);
    take_number(f, "oversample", &options->oversample, 0.25, 4);
    options->sheet.footprint = (cvol_sheet_footprint)take_word(
        f, "footprint", &sheet_footprint_words, CVOL_SHEET_LINEAR);
    const int channel_status = take_channels(out, all, f);
    if (channel_status)
        return channel_status;
    view_take_overlays(out, f);
    fields_end(f);
    const cvol_histogram *h = &out->volume->histogram;
    const int is_projection = options->mode != CVOL_MODE_ISO &&
                              options->mode != CVOL_MODE_COMPOSITE;
    if (is_projection && out->volume->times > 1 && !(options->window[0] < options->window[1])) {
        options->window[0] = h->min; /* all times have the same grey levels */
        options->window[1] = h->max;
    }
    if (!out->has_surface_value)
        options->surface.value = h->min + (h->max - h->min) / 2;
    if (options->mode == CVOL_MODE_ISO && !(options->window[0] < options->window[1]))
        cvol_histogram_get_window(options->window, h); /* of cut faces, as cvol render does */
    return fields_ok(f) ? 0 : 400;
}

int view_open(cvol_context *context, view *v)
{
    shown_volume *at;
    if (v->volume->series)
        return CVOL_OK;
    int code = times_hold(context, &at, v->volume, v->time);
    if (code)
        return code;
    volume_release(v->volume);
    v->volume = at;
    for (int c = 0; c < v->channel_count && !code; c++)
        code = view_open(context, &v->channels[c]);
    return code;
}

/* A copy with its own points and channels; 0: no memory, and *out is valid. */
static int copy_view(view *out, const view *v)
{
    *out = *v;
    out->channel_count = 0;
    out->channels = v->channel_count ? calloc((size_t)v->channel_count, sizeof *out->channels)
                                     : NULL;
    out->points = v->point_count ? malloc(v->point_count * sizeof *out->points) : NULL;
    volume_hold(out->volume);
    if (out->points)
        memcpy(out->points, v->points, v->point_count * sizeof *out->points);
    int good = (out->points || !v->point_count) && (out->channels || !v->channel_count);
    for (int c = 0; c < v->channel_count && good; c++)
        good = copy_view(&out->channels[out->channel_count++], &v->channels[c]);
    return good;
}

int view_open_at(cvol_context *context, view *out, const view *v, int time)
{
    if (!copy_view(out, v))
        return CVOL_ERROR_MEMORY;
    out->time = time;
    for (int c = 0; c < out->channel_count; c++)
        out->channels[c].time = time;
    return view_open(context, out);
}

void view_free(view *v)
{
    for (int c = 0; c < v->channel_count; c++)
        view_free(&v->channels[c]);
    volume_release(v->volume);
    free(v->channels);
    free(v->points);
    *v = (view){0};
}
