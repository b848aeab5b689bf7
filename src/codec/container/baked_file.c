/* Baked volumes: runs of slices, each coded independently, so that threads share the work. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/brick/brick_code.h"
#include "codec/container/baked_head.h"
#include "codec/container/plane_file.h"

/* The number of slices in a run. */
enum { RUN = 16, CLASSES = 2 };

void cvol_baked_file_samples(size_t out[2], const cvol_baked_file *file)
{
    out[0] = file->grid.dims[file->axis == 0 ? 1 : 0];
    out[1] = file->grid.dims[file->axis == 2 ? 1 : 2];
}

static cvol_plane_shape shape_of(const cvol_baked_file *file)
{
    cvol_plane_shape shape = {.transform = file->transform, .block = file->tile};
    cvol_baked_file_samples(shape.dims, file);
    return shape;
}

void cvol_baked_file_free(cvol_baked_file *file)
{
    for (size_t k = 0; file->planes && k < file->slices; k++)
        for (int c = 0; c < CVOL_BAKED_PLANES; c++)
            cvol_array_free(file->planes[k][c]);
    free(file->planes);
    free(file->points);
    *file = (cvol_baked_file){0};
}

/* The coding order of a slice's planes: opacity, then colours. */
static int plane_of(int i)
{
    return i ? i - 1 : CVOL_BAKED_OPACITY;
}

/* One run, and the thread's context for it. */
typedef struct run {
    cvol_context context; /* single-threaded, without progress */
    cvol_bytes bytes;     /* writing */
    cvol_span span;       /* reading */
    int code;
} run;

static size_t run_count(const cvol_baked_file *file)
{
    return (file->slices + RUN - 1) / RUN;
}

static run *make_runs(const cvol_context *context, size_t count)
{
    run *runs = calloc(count, sizeof *runs);
    for (size_t r = 0; runs && r < count; r++) {
        runs[r].context = *context;
        runs[r].context.threads = 1;
        runs[r].context.progress = NULL;
    }
    return runs;
}

static void free_runs(run *runs, size_t count)
{
    for (size_t r = 0; runs && r < count; r++)
        cvol_bytes_free(&runs[r].bytes);
    free(runs);
}

static int first_failure(cvol_context *context, const run *runs, size_t count)
{
    for (size_t r = 0; r < count; r++)
        if (runs[r].code)
            return cvol_fail(context, runs[r].code, "%s", runs[r].context.message);
    return CVOL_OK;
}

/* ---- the step ------------------------------------------------------------------------------- */

double cvol_baked_file_step(const cvol_baked_file *file)
{
    double squares = 0, terms = 1;
    for (size_t k = 0; k < file->slices; k++)
        for (int c = 0; c < CVOL_BAKED_PLANES; c++)
            if (file->planes[k][c]) {
                cvol_array_info info;
                cvol_array_get_info(&info, file->planes[k][c]);
                squares += info.l2_error * info.l2_error;
                terms += (double)info.coefficients;
            }
    return fmin(fmax(sqrt(3 * squares / terms), 1.0 / 1024), 1);
}

/* ---- writing -------------------------------------------------------------------------------- */

static int put_run(run *r, float *errors, const cvol_baked_file *file, size_t first)
{
    const cvol_plane_shape shape = shape_of(file);
    const size_t end = first + RUN < file->slices ? first + RUN : file->slices;
    cvol_tile_contexts contexts[CLASSES];
    cvol_range_encoder encoder = {0};
    int code = CVOL_OK;
    for (int i = 0; i < CLASSES; i++)
        cvol_tile_contexts_start(&contexts[i]);
    cvol_range_encoder_start(&encoder);
    for (size_t k = first; k < end && !code; k++) {
        int32_t *before = NULL;
        for (int i = 0; i <= file->channels && file->planes[k][CVOL_BAKED_OPACITY] && !code; i++) {
            const cvol_tile_coder coder = {.encoder = &encoder, .contexts = &contexts[i > 0]};
            cvol_array *rounded;
            int32_t *values = NULL;
            code = cvol_plane_quantise(&r->context, &rounded, file->planes[k][plane_of(i)],
                                       file->step);
            if (!code)
                code = cvol_plane_values(&r->context, &values, rounded, file->step);
            if (!code)
                (void)cvol_plane_code(&coder, values, before, &shape);
            if (!code)
                errors[(size_t)(file->channels + 1) * k + (size_t)i] =
                    (float)(rounded->error_bound.l2_error * (1 + 1e-6));
            cvol_array_free(rounded);
            free(before);
            before = values;
        }
        free(before);
    }
    if (!code && !cvol_range_encoder_finish(&encoder, &r->bytes))
        code = cvol_fail_memory(&r->context, r->bytes.size, "baked slices");
    cvol_range_encoder_free(&encoder);
    return code;
}

static int put_planes(cvol_context *context, cvol_bytes *out, const cvol_baked_file *file)
{
    const size_t count = run_count(file),
                 errors_count = file->slices * (size_t)(file->channels + 1);
    run *runs = make_runs(context, count);
    float *errors = cvol_allocate(errors_count, sizeof *errors);
    if (!runs || !errors) {
        free_runs(runs, count);
        free(errors);
        return cvol_fail_memory(context, errors_count * sizeof *errors, "baked slices");
    }
    for (size_t i = 0; i < errors_count; i++)
        errors[i] = -1; /* no such plane */
#pragma omp parallel for schedule(dynamic) num_threads(cvol_context_threads(context))
    for (size_t r = 0; r < count; r++)
        runs[r].code = put_run(&runs[r], errors, file, RUN * r);
    int code = first_failure(context, runs, count);
    for (size_t i = 0; i < errors_count; i++) {
        uint32_t bits;
        memcpy(&bits, &errors[i], sizeof bits);
        cvol_bytes_put_u32(out, bits);
    }
    for (size_t r = 0; r < count; r++)
        cvol_bytes_put_u32(out, (uint32_t)runs[r].bytes.size);
    for (size_t r = 0; r < count; r++)
        cvol_bytes_append(out, runs[r].bytes.data, runs[r].bytes.size);
    if (!code && out->failed)
        code = cvol_fail_memory(context, out->size, "baked slices");
    free_runs(runs, count);
    free(errors);
    return code;
}

int cvol_baked_file_put(cvol_context *context, cvol_bytes *out, const cvol_baked_file *file)
{
    cvol_bytes head = {0}, planes = {0};
    cvol_baked_head_put(&head, file);
    int code = put_planes(context, &planes, file);
    if (!code)
        code = cvol_plane_file_put(context, out, CVOL_BAKE, &head, &planes);
    cvol_bytes_free(&head);
    cvol_bytes_free(&planes);
    return code;
}

/* ---- reading -------------------------------------------------------------------------------- */

static int take_run(run *r, cvol_baked_file *out, const float *errors, size_t first,
                    const char *name)
{
    const cvol_plane_shape shape = shape_of(out);
    const size_t end = first + RUN < out->slices ? first + RUN : out->slices;
    const size_t places = (size_t)cvol_plane_places(&shape);
    cvol_tile_contexts contexts[CLASSES];
    cvol_range_decoder decoder;
    int32_t *values = cvol_allocate(2 * places, sizeof *values);
    int code = values ? CVOL_OK
                      : cvol_fail_memory(&r->context, 2 * places * sizeof *values, "baked slices");
    for (int i = 0; i < CLASSES; i++)
        cvol_tile_contexts_start(&contexts[i]);
    cvol_range_decoder_start(&decoder, r->span.data, r->span.size);
    for (size_t k = first; k < end && !code; k++) {
        const float *of = errors + (size_t)(out->channels + 1) * k;
        for (int i = 0; i <= out->channels && of[0] >= 0 && !code; i++) {
            const cvol_tile_coder coder = {.decoder = &decoder, .contexts = &contexts[i > 0]};
            int32_t *at = values + (i & 1 ? places : 0);
            const int32_t *before = i ? values + (i & 1 ? 0 : places) : NULL;
            cvol_array **plane = &out->planes[k][plane_of(i)];
            if (!cvol_plane_code(&coder, at, before, &shape) ||
                cvol_range_decoder_overrun(&decoder))
                code = cvol_fail(&r->context, CVOL_ERROR_CORRUPT,
                                 "%s: section PLNS: slice %zu is damaged", name, k);
            if (!code)
                code = cvol_plane_array(&r->context, plane, at, &shape, out->step, name);
            if (!code) {
                (*plane)->error_bound = (cvol_error_bound){
                    .l2_error = (double)of[i], .max_abs = 1 + (double)of[i], .value_max = 1};
                cvol_array_derive_figures(*plane);
            }
        }
    }
    free(values);
    return code;
}

static int fail(cvol_context *context, const char *name, const char *what)
{
    return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section PLNS: %s", name, what);
}

/* Reads the bounds of planes: a slice has all of its planes or none. */
static int take_errors(cvol_context *context, float **out, const cvol_baked_file *file,
                       cvol_cursor *content, const char *name)
{
    const size_t planes = (size_t)(file->channels + 1), count = file->slices * planes;
    *out = NULL;
    if (cvol_cursor_left(content) < 4 * count)
        return fail(context, name, "is too short");
    float *errors = cvol_allocate(count, sizeof *errors);
    if (!errors)
        return cvol_fail_memory(context, count * sizeof *errors, "baked slices");
    int sound = 1;
    for (size_t i = 0; i < count; i++) {
        const uint32_t bits = cvol_cursor_u32(content);
        memcpy(&errors[i], &bits, sizeof bits);
        sound &= errors[i] >= -1 && errors[i] <= 1e30f &&
                 (errors[i] < 0) == (errors[i - i % planes] < 0);
    }
    if (!sound) {
        free(errors);
        return fail(context, name, "a bound is invalid");
    }
    *out = errors;
    return CVOL_OK;
}

static int find_runs(cvol_context *context, run *runs, size_t count, cvol_cursor *content,
                     const char *name)
{
    for (size_t r = 0; r < count; r++)
        runs[r].span.size = cvol_cursor_u32(content);
    for (size_t r = 0; r < count; r++)
        runs[r].span.data = cvol_cursor_take(content, runs[r].span.size);
    return content->failed || cvol_cursor_left(content)
               ? fail(context, name, "its lengths of runs are invalid")
               : CVOL_OK;
}

static int take_planes(cvol_context *context, cvol_baked_file *out, const cvol_section *section,
                       const char *name)
{
    const cvol_plane_shape shape = shape_of(out);
    const size_t count = run_count(out);
    cvol_cursor content = cvol_section_cursor(section);
    float *errors;
    int code = cvol_plane_file_check(context, &shape,
                                     (uint64_t)out->slices * (uint64_t)(out->channels + 1),
                                     section->length, name);
    if (!code)
        code = take_errors(context, &errors, out, &content, name);
    if (code)
        return code;
    run *runs = make_runs(context, count);
    out->planes = cvol_allocate_zero(out->slices, sizeof *out->planes);
    code = runs && out->planes
               ? find_runs(context, runs, count, &content, name)
               : cvol_fail_memory(context, out->slices * sizeof *out->planes, "baked slices");
    if (!code) {
#pragma omp parallel for schedule(dynamic) num_threads(cvol_context_threads(context))
        for (size_t r = 0; r < count; r++)
            runs[r].code = take_run(&runs[r], out, errors, RUN * r, name);
        code = first_failure(context, runs, count);
    }
    free_runs(runs, count);
    free(errors);
    return code;
}

int cvol_baked_file_take(cvol_context *context, cvol_baked_file *out, const uint8_t *data,
                         size_t size, const char *name)
{
    cvol_section head, planes;
    *out = (cvol_baked_file){0};
    int code = cvol_plane_file_take(context, &head, &planes, CVOL_BAKE, data, size, name);
    if (code)
        return code;
    cvol_cursor content = cvol_section_cursor(&head);
    code = cvol_baked_head_take(context, out, &content, name);
    if (!code)
        code = take_planes(context, out, &planes, name);
    if (code)
        cvol_baked_file_free(out);
    return code;
}
