/* Volumes with exact samples, with bounded errors, or with samples that have no value: a base,
 * compressed as any other volume, with a mask and a residual. */
#include "codec/rate/compress_residual.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "array/core/summary.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "codec/container/array_file.h"
#include "codec/container/ranges.h"
#include "codec/mask/mask_make.h"
#include "codec/rate/compress_terms.h"
#include "codec/rate/measure.h"
#include "codec/rate/outliers.h"
#include "codec/rate/residual_step.h"
#include "codec/rate/step_search.h"
#include "codec/residual/make_labels.h"
#include "codec/residual/make_residual.h"

enum {
    TRIES_MAX = 12,
    PATIENT_TRIES = 4, /* of TRIES_MAX: these expect that the PSNR follows the step */
    /* For a base that serves only as a preview: its share of the file, and the finest and the
     * coarsest step. A block's mean is 64 times as large in its terms, so terms remain at coarser
     * steps than the range. */
    PREVIEW_SHARE = 20,
    PREVIEW_STEPS = 64,
    PREVIEW_COARSEST = 64,
    PREVIEW_OF_LABELS = 8, /* the finest step for labels, in ranges */
    LABELS_SURE = 4,
    LABELS_LEAST = 128 /* smaller files gain nothing by labels */
};

/* Single precision cannot distinguish terms of samples with a smaller range. */
#define MIN_SPAN 1e-30

/* One compression. */
typedef struct modes {
    cvol_context *context;
    const cvol_compress_options *options;
    const cvol_grid *grid;
    const void *samples;
    void *filled;       /* NULL: same as samples */
    void *clamped;      /* filled without outliers, for the base of a residual; NULL: same as
                           filled */
    double least, most; /* with clamped: of the samples that have a value, outliers too */
    cvol_mask *mask;
    cvol_summary summary; /* with a mask: of the samples that have a value */
    double bound;         /* of every sample; negative: none */
    cvol_label_fit fit;   /* with labels in place of a residual */
    cvol_attempt attempt;
} modes;

/* ---- masks ------------------------------------------------------------------------------ */

/* Finds the fills that the options give and, for lossless compression, the fills among the
 * samples. */
static int find_fills(modes *m, cvol_fills *fills)
{
    const cvol_compress_options *options = m->options;
    const int nonfinite = options->has_fill || m->bound == 0;
    uint64_t bits;
    *fills = (cvol_fills){0};
    if (options->has_fill && isfinite(options->fill)) {
        if (!cvol_fills_of_value(&bits, m->grid->type, options->fill))
            return cvol_fail(m->context, CVOL_ERROR_ARGUMENT, "%s cannot hold the fill value %g",
                             cvol_type_name(m->grid->type), options->fill);
        cvol_fills_add(fills, bits);
    }
    if (nonfinite &&
        !cvol_fills_add_nonfinite(fills, m->grid->type, m->samples, cvol_grid_samples(m->grid)))
        return cvol_fail(m->context, CVOL_ERROR_DATA,
                         "samples have more than %d different NaN or infinite values and fills",
                         (int)CVOL_FILLS_MAX);
    return CVOL_OK;
}

static int make_mask(modes *m)
{
    cvol_fills fills;
    const int code = find_fills(m, &fills);
    return code || !fills.count
               ? code
               : cvol_mask_make(m->context, &m->mask, &m->filled, m->samples, m->grid, &fills);
}

/* With a mask, encode attempts see filled samples, and with outliers clamped ones: the file's
 * summary counts the original samples that have a value. */
static int summarise(modes *m)
{
    if (m->options->no_histogram)
        return CVOL_OK;
    return cvol_summarise_samples(m->context, &m->summary, m->samples, m->grid,
                                  m->mask ? cvol_mask_fills(m->mask) : NULL);
}

static int set_summary(const modes *m, cvol_array *array)
{
    return m->summary.state == CVOL_SUMMARY_KNOWN
               ? cvol_array_set_summary(m->context, array, &m->summary)
               : CVOL_OK;
}

/* ---- the volume ------------------------------------------------------------------------- */

/* Makes the array of a step, with its own tables. */
static int make_base(modes *m, double step)
{
    cvol_attempt *attempt = &m->attempt;
    int code = cvol_attempt_sample(m->context, attempt, step);
    if (!code && attempt->may_lap) {
        attempt->shape->lapped = 1;
        code = cvol_attempt_choose_lap(m->context, attempt, step);
        if (!code)
            code = cvol_attempt_sample(m->context, attempt, step);
    }
    if (!code)
        code = cvol_attempt_fit(m->context, attempt);
    if (!code)
        code = cvol_attempt_encode(m->context, attempt, step);
    return code ? code : cvol_attempt_decode(m->context, attempt);
}

/* Gives the encode attempt's array its residual, coded with rows fitted to it. */
static int correct(modes *m)
{
    cvol_array *array = m->attempt.array;
    cvol_token_counts *counts = cvol_allocate_zero(1, sizeof *counts);
    cvol_token_tables *fitted = cvol_token_tables_create();
    cvol_residual_data *residual = NULL;
    cvol_residual_job job;
    int code = counts && fitted ? CVOL_OK
                                : cvol_fail_memory(m->context, sizeof *counts, "the tables");
    if (!code)
        code = cvol_residual_job_start(&job, array, m->samples, m->bound);
    if (code == CVOL_ERROR_MEMORY)
        code = cvol_fail_memory(m->context, 1 << 22, "a brick");
    job.tables = fitted;
    if (!code)
        code = cvol_residual_job_run(m->context, &job, counts, NULL, NULL);
    if (!code) {
        cvol_token_tables *tables = m->attempt.coded->tables;
        cvol_token_tables_fit(fitted, counts);
        cvol_token_tables_copy_rows(tables, fitted, CVOL_ROW_RESIDUAL, CVOL_ROW_INDEX);
        job.tables = tables;
        code = cvol_residual_create(m->context, &residual, tables, cvol_brick_count(array));
    }
    if (!code)
        code = cvol_residual_job_run(m->context, &job, NULL, NULL, residual);
    free(counts);
    free(fitted);
    if (code) {
        cvol_residual_free(residual);
        return code;
    }
    residual->kind = job.rule.exact ? CVOL_RESIDUAL_EXACT : CVOL_RESIDUAL_BOUNDED;
    residual->fraction = job.fraction;
    residual->rule = job.rule;
    array->residual = &residual->as;
    return CVOL_OK;
}

/* The range includes outliers, although the base does not. */
static void widen_range(const modes *m, cvol_array *array)
{
    if (m->clamped) {
        array->error_bound.value_min = m->least;
        array->error_bound.value_max = m->most;
    }
}

/* Makes base and residual with a step that may have to grow. */
static int make_residual_data(modes *m, double *step)
{
    int code = CVOL_ERROR_TARGET;
    for (int i = 0; i < TRIES_MAX && code == CVOL_ERROR_TARGET; i++) {
        code = make_base(m, *step);
        if (!code) {
            widen_range(m, m->attempt.array);
            m->attempt.array->mask = m->mask;
            code = correct(m);
            m->attempt.array->mask = NULL;
        }
        if (code == CVOL_ERROR_TARGET)
            *step *= 4;
    }
    return code == CVOL_ERROR_TARGET
               ? cvol_fail(m->context, CVOL_ERROR_TARGET, "the bound %g cannot be kept", m->bound)
               : code;
}

/* Gives the array these samples instead of its residual, and a base that serves only as a preview.
 */
static int take_samples(modes *m, cvol_residual_data *instead)
{
    const double span = m->attempt.shape->error_bound.value_max -
                        m->attempt.shape->error_bound.value_min;
    double step = fmax(m->attempt.step, instead->kind == CVOL_RESIDUAL_LABELS
                                            ? PREVIEW_OF_LABELS * span
                                            : span / PREVIEW_STEPS);
    int code;
    do
        code = make_base(m, step);
    while (!code && m->attempt.result.bytes > instead->data.size / PREVIEW_SHARE &&
           step < PREVIEW_COARSEST * span && (step *= 2) > 0);
    if (code) {
        cvol_residual_free(instead);
    } else {
        widen_range(m, m->attempt.array);
        m->attempt.array->residual = &instead->as;
    }
    return code;
}

/* Replaces *best by labels if they take fewer bytes, with the preview. */
static int try_labels(modes *m, cvol_residual_data **best, size_t *bytes)
{
    cvol_residual_data *labels;
    if (m->fit == CVOL_LABELS_NOT || *bytes < LABELS_LEAST)
        return CVOL_OK;
    const int code = cvol_labels_make(m->context, &labels, m->attempt.array, m->samples,
                                      (double)(*bytes - *bytes / 8 - LABELS_LEAST / 2));
    if (!code && labels) {
        *best = labels;
        *bytes = labels->data.size;
    }
    return code;
}

/* Replaces *best by packed samples if they take fewer bytes. */
static int try_packed(modes *m, cvol_residual_data **best, size_t *bytes)
{
    cvol_residual_data *packed;
    const int code = cvol_residual_pack(m->context, &packed, m->samples, m->grid);
    if (!code && packed->data.size <= *bytes - *bytes / 32) {
        cvol_residual_free(*best);
        *best = packed;
        *bytes = packed->data.size;
    } else if (!code) {
        cvol_residual_free(packed);
    }
    return code;
}

/* Codes the samples themselves instead of a residual if that takes fewer bytes than base and
 * residual. */
static int try_samples(modes *m)
{
    const cvol_residual_data *now = cvol_residual_of(m->attempt.array);
    size_t bytes = now->data.size + (size_t)m->attempt.result.bytes;
    cvol_residual_data *best = NULL;
    const int may_pack = cvol_packed_may_fit(m->samples, m->grid, (double)bytes);
    int code = may_pack < 0 ? cvol_fail_memory(m->context, bytes, "packed samples")
                            : try_labels(m, &best, &bytes);
    if (!code && may_pack)
        code = try_packed(m, &best, &bytes);
    if (code)
        cvol_residual_free(best);
    return code || !best ? code : take_samples(m, best);
}

/* Codes labels, and no residual, if labels are surely smaller: zstd at a fast level takes up to
 * about twice the bytes of a file with a residual (compress_choice.c), and here at least
 * LABELS_SURE times those of the labels. */
static int try_labels_alone(modes *m, int *done)
{
    cvol_residual_data *labels;
    *done = 0;
    if (m->fit != CVOL_LABELS_WELL || m->clamped)
        return CVOL_OK;
    double packed;
    int code = cvol_packed_estimate(m->context, &packed, m->samples, m->grid);
    const double most = packed / LABELS_SURE;
    if (code || most < LABELS_LEAST)
        return code;
    code = cvol_labels_make(m->context, &labels, m->attempt.shape, m->samples, most);
    *done = !code && labels;
    return *done ? take_samples(m, labels) : code;
}

/* The terms are those of samples without outliers, which only the residual restores: the bound of
 * the terms' error must include them. */
static int include_outliers(modes *m)
{
    cvol_array *array = m->attempt.array;
    cvol_distance distance;
    const int code = cvol_measure_distance(m->context, &distance, array,
                                           m->filled ? m->filled : m->samples);
    if (code)
        return code;
    const double max_abs = array->error_bound.max_abs; /* outliers are not in the terms */
    cvol_array_set_bounds(array, &distance);
    array->error_bound.max_abs = max_abs;
    /* Files have finite bounds; the squares of the largest doubles are infinite. */
    array->error_bound.l2_error = fmin(array->error_bound.l2_error, DBL_MAX);
    return CVOL_OK;
}

/* Gives the array its mask and its bricks, and measures it. */
static int finish(modes *m, int *same)
{
    cvol_array *array = m->attempt.array;
    array->mask = m->mask;
    m->mask = NULL;
    if (m->attempt.coded) {
        cvol_coded_attach(array, m->attempt.coded);
        m->attempt.coded = NULL;
    }
    int code = m->clamped ? include_outliers(m) : CVOL_OK;
    if (!code && cvol_array_may_have_ranges(array, m->attempt.result.bytes))
        code = cvol_ranges_find(m->context, array);
    return code ? code : cvol_measure_stored(m->context, array, m->samples, same);
}

static int check_finished(const modes *m, int same)
{
    const cvol_array *array = m->attempt.array;
    if (m->bound == 0 ? same : array->max_error <= m->bound)
        return CVOL_OK;
    return cvol_fail(m->context, CVOL_ERROR_TARGET,
                     "a maximum error of %g was requested, %g was reached", m->bound,
                     array->max_error);
}

/* With a bound, and perhaps a PSNR target. */
static int run_bound(modes *m, int *same)
{
    const int wants_psnr = m->options->target == CVOL_TARGET_PSNR && !m->options->lossless;
    const double wanted = wants_psnr ? m->options->target_value : 0;
    const void *samples = m->filled ? m->filled : m->samples;
    double step;
    int done = 0;
    int code = cvol_outliers_clamp(m->context, &m->clamped, samples, m->grid);
    if (!code && m->clamped) {
        code = cvol_scan_samples(m->context, &m->least, &m->most, samples, m->grid);
        cvol_attempt_widen_range(&m->least, &m->most, m->grid->type, m->options);
        samples = m->clamped;
        if (!code && !m->mask)
            code = summarise(m);
    }
    if (!code)
        code = cvol_attempt_start(m->context, &m->attempt, samples, m->grid, m->options);
    if (!code)
        cvol_attempt_set_options(&m->attempt, m->options);
    if (!code)
        code = set_summary(m, m->attempt.shape);
    if (!code && m->bound == 0 && !m->mask)
        m->fit = cvol_labels_judge(m->samples, m->grid);
    if (!code)
        code = try_labels_alone(m, &done);
    if (!code && done)
        code = finish(m, same);
    if (done)
        return code ? code : check_finished(m, *same);
    if (!code &&
        !(m->attempt.shape->error_bound.value_max - m->attempt.shape->error_bound.value_min >
          MIN_SPAN))
        step = 1; /* no terms */
    else if (!code)
        code = cvol_residual_step(m->context, &step,
                                  &(cvol_residual_step_input){.options = m->options,
                                                              .grid = m->grid,
                                                              .samples = samples,
                                                              .mask = m->mask,
                                                              .bound = m->bound,
                                                              .whole = m->attempt.shape});
    if (code)
        return code;
    for (int i = 0; i < TRIES_MAX && !code; i++) {
        code = make_residual_data(m, &step);
        if (!code && m->bound == 0)
            code = try_samples(m);
        if (!code)
            code = finish(m, same);
        if (!code)
            code = check_finished(m, *same);
        const double short_of = code ? 0 : wanted - m->attempt.array->psnr_db;
        if (code || short_of <= 0)
            return code;
        /* The PSNR is too low: take a finer base. If integers have few values, rounding hides most
         * of a change of the step, so later tries ask for more. */
        const int times = i < PATIENT_TRIES ? 1 : 1 << (i - PATIENT_TRIES + 1);
        step *= cvol_pow(10, -times * (short_of + 0.1) / 20);
        m->mask = m->attempt.array->mask;
        m->attempt.array->mask = NULL;
    }
    return code ? code
                : cvol_fail(m->context, CVOL_ERROR_TARGET,
                            "a PSNR of %g dB cannot be reached for these %s samples", wanted,
                            cvol_type_name(m->grid->type));
}

/* ---- cvol_compress ---------------------------------------------------------------------- */

/* Fills the report with the figures of the finished array. */
static int fill_report(modes *m, cvol_compress_report *report, const cvol_array *array, int same)
{
    uint64_t bytes;
    const int code = cvol_array_file_bytes(m->context, array, &bytes);
    if (code)
        return code;
    report->ratio = (double)cvol_grid_bytes(m->grid) / (double)bytes;
    report->psnr_db = array->psnr_db;
    report->max_error = array->max_error;
    report->file_bytes = bytes;
    report->lossless = same;
    report->coefficients = array->coefficients;
    return CVOL_OK;
}

/* Tests the target for the volume with its mask; if it fails, sets the next target to try in
 * *plain. */
static int is_held(const modes *m, cvol_compress_options *plain, const cvol_compress_report *report)
{
    const double wanted = m->options->target_value;
    if (m->options->target == CVOL_TARGET_PSNR) {
        const double short_of = wanted - report->psnr_db;
        plain->target_value += short_of > 0 ? short_of + 0.02 : 0;
        return short_of <= 0;
    }
    /* The factor by which it is too large. */
    const double bits = 8 * (double)report->file_bytes / (double)cvol_grid_samples(m->grid);
    const double over = m->options->target == CVOL_TARGET_BITS ? bits / wanted
                                                               : wanted / report->ratio;
    plain->target_value *= m->options->target == CVOL_TARGET_BITS ? 0.998 / over : 1.002 * over;
    return over <= 1 || !report->target_met;
}

/* Without a bound: compresses the filled samples as usual, then adjusts the target for the change
 * that the mask makes. Without a residual, which would need the mask: the caller tries lossless
 * compression separately. */
static int run_filled(modes *m, cvol_array **out, cvol_compress_report *report)
{
    cvol_compress_options plain = *m->options;
    plain.has_fill = 0;
    plain.background = CVOL_BACKGROUND_NONE;
    for (int i = 0; i < TRIES_MAX; i++) {
        int same;
        int code = cvol_compress_terms(m->context, out, report, m->filled ? m->filled : m->samples,
                                       m->grid, &plain);
        if (code || !*out || !m->mask)
            return code;
        (*out)->mask = m->mask;
        code = set_summary(m, *out);
        if (!code)
            code = cvol_measure_stored(m->context, *out, m->samples, &same);
        if (!code)
            code = fill_report(m, report, *out, same);
        if (code || is_held(m, &plain, report)) {
            m->mask = NULL;
            return code;
        }
        (*out)->mask = NULL;
        cvol_array_free(*out);
        *out = NULL;
    }
    return cvol_fail(m->context, CVOL_ERROR_TARGET,
                     "%g cannot be reached for these %s samples and their mask",
                     m->options->target_value, cvol_type_name(m->grid->type));
}

int cvol_compress_residual(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                           const void *samples, const cvol_grid *grid,
                           const cvol_compress_options *options)
{
    cvol_compress_report unused;
    int same = 0, code = cvol_grid_check(context, grid, "the volume");
    modes *m = calloc(1, sizeof *m);
    *out = NULL;
    if (!code && !m)
        code = cvol_fail_memory(context, sizeof *m, "the compression");
    if (code) {
        free(m);
        return code;
    }
    report = report ? report : &unused;
    *m = (modes){.context = context, .options = options, .grid = grid, .samples = samples};
    m->bound = options->lossless                          ? 0
               : options->target == CVOL_TARGET_MAX_ERROR ? options->target_value
               : options->max_error > 0                   ? options->max_error
                                                          : -1;
    if (cvol_type_is_integer(grid->type) && m->bound > 0 && m->bound < 1)
        m->bound = 0;
    code = make_mask(m);
    if (!code && m->mask)
        code = summarise(m);
    if (!code && m->bound < 0) {
        code = run_filled(m, out, report);
    } else if (!code) {
        code = run_bound(m, &same);
        *report = (cvol_compress_report){.target_met = 1, .trials = m->attempt.count};
        if (!code)
            code = fill_report(m, report, m->attempt.array, same);
        if (!code) {
            *out = m->attempt.array;
            m->attempt.array = NULL;
        }
    }
    if (code) {
        cvol_array_free(*out);
        *out = NULL;
    }
    cvol_attempt_free(&m->attempt);
    cvol_mask_free(m->mask);
    free(m->filled);
    free(m->clamped);
    free(m);
    return code;
}
