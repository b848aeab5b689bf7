/* The difference of the pictures of two volumes. Both use the colours, the window and the quality
 * of the first. */
#include "viewer/requests/difference.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "viewer/requests/frame.h"
#include "viewer/volumes/times.h"
#include "viewer/volumes/volume_renderers.h"

typedef struct difference {
    frame_request frame; /* of the first */
    shown_volume *other; /* held */
    int other_time;
    double gain;
} difference;

/* ---- shared settings ------------------------------------------------------------------------
 */

/* Without a window: sets that of the first volume. */
static int share_window(cvol_context *context, view *v)
{
    double *window = v->options.window;
    if (window[0] < window[1])
        return CVOL_OK;
    idle_renderer *renderer = volume_take_renderer(context, v->volume, 0);
    const int code = renderer ? cvol_renderer_get_range(context, window, renderer->renderer)
                              : CVOL_ERROR_MEMORY;
    volume_return_renderer(v->volume, renderer);
    return code;
}

static int share_settings(cvol_context *context, view *v)
{
    switch (v->options.mode) {
    case CVOL_MODE_COMPOSITE:
        return view_fix_colours(context, v);
    case CVOL_MODE_ISO:
        return CVOL_OK;
    default:
        return share_window(context, v);
    }
}

/* ---- pictures ---------------------------------------------------------------------------------
 */

/* a becomes |a - b| gain. */
static void subtract(cvol_image *a, const cvol_image *b, double gain)
{
    const size_t bytes = 4 * (size_t)a->width * (size_t)a->height;
    for (size_t i = 0; i < bytes; i++)
        if (i % 4 != 3)
            a->rgba[i] = (uint8_t)fmin(255, abs(a->rgba[i] - b->rgba[i]) * gain + 0.5);
}

/* Draws the second picture, with the quality of the first. */
static int draw_other(cvol_context *context, cvol_image **out, double *ms, const difference *d,
                      int rung)
{
    frame_request other = d->frame;
    frame_figures figures;
    other.view.volume = d->other;
    other.view.time = d->other_time;
    other.motion = 0;
    pace_apply(&other.view.options, rung);
    const int code = frame_draw(context, out, &figures, &other, NULL);
    *ms = figures.render_ms;
    return code;
}

/* Replaces the other volume by the one at its time. */
static int open_other(cvol_context *context, difference *d)
{
    shown_volume *at;
    const int code = times_hold(context, &at, d->other, d->other_time);
    if (code)
        return code;
    volume_release(d->other);
    d->other = at;
    return CVOL_OK;
}

static answer run(job *j, cvol_context *context, void *state)
{
    difference *d = state;
    frame_figures figures;
    cvol_image *image = NULL, *other = NULL;
    cvol_image_difference result;
    double ms = 0;
    d->frame.budget_ms /= 2;
    int code = view_open(context, &d->frame.view);
    if (!code)
        code = open_other(context, d);
    if (!code)
        code = share_settings(context, &d->frame.view);
    if (!code)
        code = frame_draw(context, &image, &figures, &d->frame, j->pace);
    if (!code)
        code = draw_other(context, &other, &ms, d, figures.rung);
    if (!code)
        code = cvol_image_compare(context, &result, image, other);
    if (code) {
        cvol_image_free(image);
        cvol_image_free(other);
        return jobs_failed(j, context, code);
    }
    figures.render_ms += ms;
    subtract(image, other, d->gain);
    cvol_image_free(other);
    json_t *more = json_pack("{s:o, s:b, s:o, s:o}", "psnr_db", answer_number(result.psnr_db),
                             "exact", isinf(result.psnr_db) && result.psnr_db > 0,
                             "psnr_foreground_db", answer_number(result.psnr_foreground_db), "ssim",
                             answer_number(result.ssim));
    const answer a = frame_answer(context, j, image, &figures, &d->frame, more);
    cvol_image_free(image);
    return a;
}

/* ---- requests ---------------------------------------------------------------------------------
 */

static void free_difference(void *state)
{
    difference *d = state;
    view_free(&d->frame.view);
    volume_release(d->other);
    free(d);
}

/* Reads the other volume, which must have the same shape; time -1: that of the view, if both have
 * as many times. 0, or a status. */
static int take_other(difference *d, volumes *all, const char *id, int time, fields *f)
{
    const shown_volume *v = d->frame.view.volume;
    d->other = volumes_hold(all, id);
    if (!d->other) {
        fields_fail(f, "other is '%s': there is no such volume", id);
        return 404;
    }
    if (!volume_is_ready(d->other)) {
        char why[UNREADY_BYTES];
        volume_say_unready(why, sizeof why, d->other, id);
        fields_fail(f, "%s", why);
        return 409;
    }
    const size_t *a = v->grid.dims, *b = d->other->grid.dims;
    if (memcmp(a, b, sizeof v->grid.dims))
        fields_fail(
            f,
            "the volumes must have the same shape: %.80s has %zu x %zu x %zu samples, %.80s "
            "has %zu x %zu x %zu",
            v->name, a[0], a[1], a[2], d->other->name, b[0], b[1], b[2]);
    d->other_time = time >= 0 ? time : d->other->times == v->times ? d->frame.view.time : 0;
    if (d->other_time >= d->other->times)
        fields_fail(f, "other_time is %d, must be 0 to %d", d->other_time, d->other->times - 1);
    return fields_ok(f) ? 0 : 400;
}

static int take(difference *out, volumes *all, fields *f)
{
    char id[VOLUME_ID_BYTES] = "";
    int time = -1;
    out->gain = 8;
    if (!take_text(f, "other", id, sizeof id))
        fields_fail(f, "other is missing: give the id of the second volume");
    take_integer(f, "other_time", &time, 0, INT_MAX);
    take_number(f, "gain", &out->gain, 0, 255);
    const int status = fields_ok(f) ? frame_take(&out->frame, all, f) : 400;
    if (!status && out->frame.view.channel_count)
        fields_fail(f, "view.channels: a difference is of one volume; leave out the channels");
    fields_end(f);
    return status ? status : !fields_ok(f) ? 400 : take_other(out, all, id, time, f);
}

answer difference_post(request *r)
{
    char error[512] = "";
    json_t *body;
    fields_parse(&body, r->body, r->body_bytes, error, sizeof error);
    fields f = {body, NULL, "", error, sizeof error};
    difference *d = body ? calloc(1, sizeof *d) : NULL;
    const int status = d ? take(d, r->service->volumes, &f) : 400;
    json_decref(body);
    if (!status)
        return request_later(r, d->frame.viewer, d->frame.sequence, frame_is_large(&d->frame), run,
                             d, free_difference);
    if (d)
        free_difference(d);
    return answer_error(status, "%s", error[0] ? error : "not enough memory for a request");
}
