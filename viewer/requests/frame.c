/* Frames. */
#include "viewer/requests/frame.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "viewer/base/encode.h"
#include "viewer/view/channels.h"
#include "viewer/volumes/volume_renderers.h"

enum { MOTION_SIZE_MAX = 4096, MOTION_JPEG = 85 };

static const double motion_budget_ms = 20;
/* Stills with more rays are usually for saving: they run in the background. */
static const double large_rays = 2e6;

/* "rows": [first, count], the rows of the picture to draw. */
static void take_rows(cvol_render_options *options, fields *f)
{
    double rows[2];
    if (!take_numbers(f, "rows", rows, 2) || !fields_ok(f))
        return;
    const int all = options->height;
    if (!(rows[0] >= 0 && rows[1] >= 1 && rows[0] + rows[1] <= all) || rows[0] != floor(rows[0]) ||
        rows[1] != floor(rows[1])) {
        fields_fail(f, "%srows must be the first row and their number, of %d rows", f->within, all);
        return;
    }
    options->rows = (cvol_rows){(int)rows[0], all};
    options->height = (int)rows[1];
}

int frame_take(frame_request *out, volumes *all, fields *f)
{
    char quality[16] = "still", format[8] = "";
    double sequence = -1;
    *out = (frame_request){.budget_ms = motion_budget_ms, .rung = RUNG_FULL};
    fields inner = take_object(f, "view", "view.");
    if (!inner.object)
        fields_fail(f, "%sview is missing: give the view of the frame", f->within);
    int status = fields_ok(f) ? view_take(&out->view, all, &inner) : 400;
    fields_end(&inner);
    take_text(f, "quality", quality, sizeof quality);
    take_text(f, "format", format, sizeof format);
    take_text(f, "viewer", out->viewer, sizeof out->viewer);
    take_number(f, "sequence", &sequence, 0, 9e15);
    take_number(f, "budget_ms", &out->budget_ms, 1, 10000);
    out->sequence = (int64_t)sequence;
    out->motion = !strcmp(quality, "motion");
    if (!out->motion && strcmp(quality, "still"))
        out->rung = pace_find(quality);
    if (out->rung < 0)
        fields_fail(f,
                    "%squality is '%s', must be still, motion, full, object order, soft, or level "
                    "1 to 3",
                    f->within, quality);
    take_rows(&out->view.options, f);
    const int png = format[0] ? !strcmp(format, "png") : !out->motion;
    if (format[0] && !png && strcmp(format, "jpeg"))
        fields_fail(f, "%sformat is '%s', must be png or jpeg", f->within, format);
    out->quality = png ? 0 : MOTION_JPEG;
    int jpeg_quality = MOTION_JPEG;
    if (take_integer(f, "jpeg_quality", &jpeg_quality, 1, 100) && !png)
        out->quality = jpeg_quality;
    const cvol_render_options *o = &out->view.options;
    if (out->motion && (o->width > MOTION_SIZE_MAX || o->height > MOTION_SIZE_MAX))
        fields_fail(f, "view.width and view.height must be at most %d in motion", MOTION_SIZE_MAX);
    return status ? status : fields_ok(f) ? 0 : 400;
}

int frame_is_large(const frame_request *frame)
{
    const cvol_render_options *o = &frame->view.options;
    const double rays = frame->motion ? 0.25 : fmax(o->oversample * o->oversample, 1);
    return rays * o->width * o->height > large_rays;
}

/* Chooses the quality of a frame. */
static cvol_render_options choose_quality(frame_figures *figures, const frame_request *frame,
                                          pace *times)
{
    const shown_volume *series = volume_series(frame->view.volume);
    cvol_render_options options = frame->view.options;
    figures->rung = frame->rung;
    if (frame->motion)
        figures->rung = times ? pace_choose(times, series, &options, frame->budget_ms)
                              : RUNG_LEVEL_1;
    pace_apply(&options, figures->rung);
    figures->level = options.level;
    return options;
}

static int draw_channels(cvol_context *context, cvol_image *image, frame_figures *figures,
                         const frame_request *frame, pace *times)
{
    const double begin = jobs_now();
    const cvol_render_options options = choose_quality(figures, frame, times);
    const int code = channels_draw(context, &frame->view, image, &options);
    figures->render_ms = jobs_now() - begin;
    if (!code && times && frame->motion)
        pace_add_time(times, figures->rung, figures->render_ms);
    return code;
}

static int draw(cvol_context *context, cvol_image *image, frame_figures *figures,
                const frame_request *frame, pace *times)
{
    shown_volume *v = frame->view.volume;
    idle_renderer *renderer = volume_take_renderer(context, v, view_shows_labels(&frame->view));
    if (!renderer)
        return CVOL_ERROR_MEMORY;
    const double begin = jobs_now();
    const cvol_render_options options = choose_quality(figures, frame, times);
    int code = view_set_transfer(context, renderer, &frame->view);
    if (!code)
        code = view_draw(context, &frame->view, renderer, image, &options);
    figures->render_ms = jobs_now() - begin;
    const unsigned level = 1u << options.level;
    /* Each time in a series is drawn for the first time, so that this is what a picture costs. */
    const int is_usual = v->series || renderer->drawn & level;
    if (!code && times && frame->motion && is_usual)
        pace_add_time(times, figures->rung, figures->render_ms);
    if (!code)
        renderer->drawn |= level;
    volume_return_renderer(v, renderer);
    return code;
}

/* 1 if every pixel is background. */
static int is_empty(const cvol_image *image, const double background[3])
{
    const size_t count = 4 * (size_t)image->width * (size_t)image->height;
    for (int c = 0; c < 3; c++)
        if (fabs(image->rgba[c] - 255 * background[c]) > 1)
            return 0;
    for (size_t i = 4; i < count; i++)
        if (image->rgba[i] != image->rgba[i % 4])
            return 0;
    return 1;
}

int frame_draw(cvol_context *context, cvol_image **out, frame_figures *figures,
               const frame_request *frame, pace *times)
{
    const view *v = &frame->view;
    *figures = (frame_figures){.rung = RUNG_FULL};
    int code = cvol_image_create(context, out, v->options.width, v->options.height);
    if (!code)
        code = (v->channel_count ? draw_channels : draw)(context, *out, figures, frame, times);
    if (!code && v->mirror)
        cvol_image_mirror(*out);
    figures->is_empty = !code && is_empty(*out, v->options.background);
    if (code) {
        cvol_image_free(*out);
        *out = NULL;
    }
    return code;
}

answer frame_answer(cvol_context *context, const job *j, const cvol_image *image,
                    frame_figures *figures, const frame_request *frame, json_t *more)
{
    char timing[160];
    const double begin = jobs_now();
    answer a = encode_picture(context, image, frame->quality);
    figures->encode_ms = jobs_now() - begin;
    json_t *object = json_pack(
        "{s:I, s:i, s:s, s:f, s:f, s:f, s:I, s:i, s:b}", "sequence",
        (json_int_t)(j->sequence > 0 ? j->sequence : 0), "level", figures->level, "quality",
        pace_name(figures->level ? RUNG_SOFT + figures->level : figures->rung), "queue_ms",
        j->queue_ms, "render_ms", figures->render_ms, "encode_ms", figures->encode_ms, "bytes",
        (json_int_t)a.size, "threads", j->threads, "empty", figures->is_empty);
    if (object && more)
        json_object_update(object, more);
    json_decref(more);
    answer_header_json(&a, "Cvol-Frame", object);
    snprintf(timing, sizeof timing, "queue;dur=%.3f, render;dur=%.3f, encode;dur=%.3f", j->queue_ms,
             figures->render_ms, figures->encode_ms);
    answer_header(&a, "Server-Timing", timing);
    return a;
}

static answer run(job *j, cvol_context *context, void *state)
{
    frame_request *frame = state;
    frame_figures figures;
    cvol_image *image;
    int code = view_open(context, &frame->view);
    if (!code)
        code = frame_draw(context, &image, &figures, frame, j->pace);
    if (code)
        return jobs_failed(j, context, code);
    const answer a = frame_answer(context, j, image, &figures, frame, NULL);
    cvol_image_free(image);
    return a;
}

static void free_frame(void *state)
{
    frame_request *frame = state;
    view_free(&frame->view);
    free(frame);
}

answer frame_post(request *r)
{
    char error[512] = "";
    json_t *body;
    fields_parse(&body, r->body, r->body_bytes, error, sizeof error);
    fields f = {body, NULL, "", error, sizeof error};
    frame_request *frame = body ? calloc(1, sizeof *frame) : NULL;
    int status = frame ? frame_take(frame, r->service->volumes, &f) : 400;
    fields_end(&f);
    json_decref(body);
    if (!status && error[0])
        status = 400;
    if (!status)
        return request_later(r, frame->viewer, frame->sequence, frame_is_large(frame), run, frame,
                             free_frame);
    if (frame)
        free_frame(frame);
    return answer_error(status, "%s", error[0] ? error : "not enough memory for a request");
}
