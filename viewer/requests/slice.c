/* Slices as pictures, one pixel per sample; and single samples. */
#include "viewer/requests/slice.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "viewer/base/encode.h"
#include "viewer/view/view.h"
#include "viewer/volumes/labels.h"
#include "viewer/volumes/samples.h"
#include "viewer/volumes/times.h"

typedef struct slice {
    shown_volume *volume; /* held */
    int time;
    int axis;
    size_t index;
    double window[2]; /* values of black and white; of the same, this value is grey */
    int is_coloured;  /* labels have their colours */
    view overlays;    /* of the volume: its list of overlays alone; volume NULL: none */
} slice;

/* ---- parameters -------------------------------------------------------------------------------
 */

/* Reads a whole number from 0 to end - 1; -1: invalid. */
static long long take_index(const request *r, const char *name, size_t end, answer *refusal)
{
    const char *text = request_query(r, name);
    if (!text) {
        *refusal = answer_error(400, "%s is missing", name);
        return -1;
    }
    char *rest;
    const long long index = strtoll(text, &rest, 10);
    if (rest == text || *rest || text[0] < '0' || text[0] > '9') {
        *refusal = answer_error(400, "%s is '%.40s', must be a whole number", name, text);
        return -1;
    }
    if ((unsigned long long)index >= end) {
        *refusal = answer_error(400, "%s is %lld, must be 0 to %zu", name, index, end - 1);
        return -1;
    }
    return index;
}

/* Reads the time, 0 without the parameter; 1 on success. */
static int take_time(int *time, const request *r, const shown_volume *v, answer *refusal)
{
    *time = request_query(r, "time") ? (int)take_index(r, "time", (size_t)v->times, refusal) : 0;
    return *time >= 0;
}

/* Reads "LO,HI"; 1 if it is valid or missing. */
static int take_window(const request *r, double window[2], answer *refusal)
{
    const char *text = request_query(r, "window");
    if (!text)
        return 1;
    char *rest;
    window[0] = strtod(text, &rest);
    int good = rest != text && *rest == ',';
    if (good) {
        const char *second = rest + 1;
        window[1] = strtod(second, &rest);
        good = rest != second && !*rest && isfinite(window[0]) && isfinite(window[1]);
    }
    if (!good)
        *refusal = answer_error(400, "window is '%.60s', must be LO,HI: two numbers", text);
    else if (window[0] > window[1])
        *refusal = answer_error(400, "window is '%.60s': the second value must be larger", text);
    return good && window[0] <= window[1];
}

/* Reads the overlays, a list as in a view; 1 on success. */
static int take_overlays(slice *out, const request *r, answer *refusal)
{
    const char *text = request_query(r, "overlays");
    char error[512] = "";
    json_error_t e;
    if (!text)
        return 1;
    json_t *list = json_loads(text, JSON_REJECT_DUPLICATES, &e);
    if (!list) {
        *refusal = answer_error(400, "overlays is not JSON: %.100s", e.text);
        return 0;
    }
    json_t *object = json_pack("{s:o}", "overlays", list);
    fields f = {object, NULL, "", error, sizeof error};
    out->overlays.volume = out->volume;
    volume_hold(out->volume);
    if (object)
        view_take_overlays(&out->overlays, &f);
    json_decref(object);
    if (error[0])
        *refusal = answer_error(400, "%s", error);
    return !error[0];
}

/* Reads the parameters of a slice; 1 on success. */
static int take_slice(slice *out, const request *r, answer *refusal)
{
    const cvol_grid *g = &out->volume->grid;
    const char *axis = request_query(r, "axis");
    if (!axis || strlen(axis) != 1 || !strchr("xyz", *axis)) {
        *refusal = answer_error(400, "axis is '%.40s', must be x, y or z", axis ? axis : "");
        return 0;
    }
    out->axis = *axis - 'x';
    const long long index = take_index(r, "index", g->dims[out->axis], refusal);
    if (index < 0)
        return 0;
    out->index = (size_t)index;
    out->window[0] = out->volume->histogram.min;
    out->window[1] = out->volume->histogram.max;
    out->is_coloured = !request_query(r, "window");
    for (int a = 0; a < 3; a++)
        if (a != out->axis && g->dims[a] > VIEW_SIZE_MAX) {
            *refusal = answer_error(400, "the slice has %zu samples along %c, must have at most %d",
                                    g->dims[a], "xyz"[a], VIEW_SIZE_MAX);
            return 0;
        }
    return take_time(&out->time, r, out->volume, refusal) && take_window(r, out->window, refusal) &&
           take_overlays(out, r, refusal);
}

/* ---- pictures ---------------------------------------------------------------------------------
 */

static uint8_t grey_of(double value, const double window[2])
{
    const double width = window[1] - window[0];
    const double share = width > 0           ? (value - window[0]) / width
                         : value > window[0] ? 1
                                             : 0.5 * (value >= window[0]);
    return (uint8_t)(share >= 1 ? 255 : share > 0 ? 255 * share + 0.5 : 0);
}

/* x to the right; z up; y of slices across z down. labels: of the samples, or NULL. */
static void paint(cvol_image *image, const double *values, const slice *s,
                  const shown_labels *labels)
{
    for (int row = 0; row < image->height; row++) {
        const int line = s->axis == 2 ? row : image->height - 1 - row;
        const double *from = values + (size_t)line * (size_t)image->width;
        uint8_t *to = image->rgba + 4 * (size_t)row * (size_t)image->width;
        for (int i = 0; i < image->width; i++, to += 4) {
            if (labels)
                labels_colour(to, labels, from[i]);
            else
                memset(to, grey_of(from[i], s->window), 3);
            to[3] = 255;
        }
    }
}

static answer run(job *j, cvol_context *context, void *state)
{
    const slice *s = state;
    const size_t *dims = s->volume->grid.dims;
    size_t begin[3] = {0}, end[3] = {dims[0], dims[1], dims[2]};
    double *values = NULL;
    cvol_image *image = NULL;
    shown_volume *at;
    begin[s->axis] = s->index;
    end[s->axis] = s->index + 1;
    int code = times_hold(context, &at, s->volume, s->time);
    if (!code)
        code = samples_read(context, &values, at, begin, end);
    if (!code)
        code = cvol_image_create(context, &image, (int)dims[s->axis == 0 ? 1 : 0],
                                 (int)dims[s->axis == 2 ? 1 : 2]);
    if (!code)
        paint(image, values, s, s->is_coloured ? at->labels : NULL);
    volume_release(at);
    if (!code)
        code = overlays_paint_slice(context, s->volume, s->overlays.overlays,
                                    s->overlays.overlay_count, image, s->axis, s->index,
                                    s->axis != 2);
    free(values);
    if (code) {
        cvol_image_free(image);
        return jobs_failed(j, context, code);
    }
    const answer a = encode_picture(context, image, 0);
    cvol_image_free(image);
    return a;
}

static void free_slice(void *state)
{
    slice *s = state;
    view_free(&s->overlays);
    volume_release(s->volume);
    free(s);
}

answer slice_get(request *r)
{
    answer refusal = {0};
    if (!request_knows(r, "axis index time window overlays", &refusal))
        return refusal;
    slice *s = calloc(1, sizeof *s);
    if (!s)
        return answer_error(500, "not enough memory for a request");
    s->volume = request_ready_volume(r, &refusal);
    if (s->volume && take_slice(s, r, &refusal))
        return request_later(r, "", -1, 0, run, s, free_slice);
    free_slice(s);
    return refusal;
}

/* ---- single samples ---------------------------------------------------------------------------
 */

typedef struct sample {
    shown_volume *volume; /* held */
    int time;
    double place[3];
} sample;

static int describe_sample(cvol_context *context, answer *out, const sample *s)
{
    shown_volume *at;
    json_t *object = NULL;
    int code = times_hold(context, &at, s->volume, s->time);
    if (!code)
        code = samples_describe(context, &object, at, s->place);
    volume_release(at);
    if (code)
        return code;
    json_object_set_new(object, "sample",
                        json_pack("[I, I, I]", (json_int_t)s->place[0], (json_int_t)s->place[1],
                                  (json_int_t)s->place[2]));
    *out = answer_json(200, object);
    return CVOL_OK;
}

static answer run_sample(job *j, cvol_context *context, void *state)
{
    answer a;
    const int code = describe_sample(context, &a, state);
    return code ? jobs_failed(j, context, code) : a;
}

static void free_sample(void *state)
{
    sample *s = state;
    volume_release(s->volume);
    free(s);
}

/* Reads the parameters of a sample; 1 on success. */
static int take_sample(sample *out, const request *r, answer *refusal)
{
    static const char *const names[] = {"x", "y", "z"};
    for (int a = 0; a < 3; a++) {
        const long long index = take_index(r, names[a], out->volume->grid.dims[a], refusal);
        if (index < 0)
            return 0;
        out->place[a] = (double)index;
    }
    return take_time(&out->time, r, out->volume, refusal);
}

answer value_get(request *r)
{
    answer result = {0};
    if (!request_knows(r, "x y z time", &result))
        return result;
    sample *s = calloc(1, sizeof *s);
    if (!s)
        return answer_error(500, "not enough memory for a request");
    s->volume = request_ready_volume(r, &result);
    const int good = s->volume && take_sample(s, r, &result);
    if (good && s->time) /* it may have to be read */
        return request_later(r, "", -1, 0, run_sample, s, free_sample);
    cvol_context *context = good ? cvol_context_create() : NULL;
    if (context) { /* one sample: not worth more threads */
        cvol_context_set_threads(context, 1);
        const int code = describe_sample(context, &result, s);
        if (code)
            result = answer_failure(context, code);
    } else if (good) {
        result = answer_error(500, "not enough memory for a context");
    }
    cvol_context_free(context);
    free_sample(s);
    return result;
}
