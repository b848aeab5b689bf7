/* Compression to a target by terms alone: the search for the step.
 *
 * A miss (search.h) is a difference of logarithms: of the ratio and the target ratio, or of PSNR in
 * units of a factor e. If the volume has many bricks, sizes are first estimated on a few. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/elementary.h"
#include "codec/container/array_file.h"
#include "codec/container/ranges.h"
#include "codec/quantize/coding.h"
#include "codec/rate/compress_terms.h"
#include "codec/rate/step_search.h"

/* The searches' aim, as a fraction of the step. */
#define FINEST_WIDTH 2e-4
/* If an encode attempt is short, the search meets a ratio more closely than cvol_compress
 * promises. */
#define SMALL_SAMPLES 4000000
#define SMALL_RATIO_AIM 1.0015
#define SMALL_RATIO_ACCEPTED 1.004
/* Effort max has time for closer aims. */
#define MAX_EFFORT_RATIO_AIM 1.0004
#define MAX_EFFORT_RATIO_ACCEPTED 1.001
#define MAX_EFFORT_PSNR_AIM 0.01
#define MAX_EFFORT_PSNR_ACCEPTED 0.025

/* If a background's mask takes more than this share of the file, the file may be smaller without
 * it. For a size target, the search spends twice the time to decide this sooner. */
#define MASK_SHARE_SURE (1 / 8.0)
#define MASK_SHARE_SURE_OF_PSNR 0.35

/* For PSNRs that jump: the steps that are tried with weights of bits, and the number of weights. */
#define FINER 0.97
#define FIRST_WEIGHT 1.1
#define WEIGHT_MAX 8
#define WEIGHT_WIDTH 2e-3

enum { ATTEMPTS_MAX = 60, FINER_MAX = 8, WEIGHTS_MAX = 10 };

/* ---- the search ------------------------------------------------------------------------- */

static double ratio_of(const cvol_compression *c)
{
    return (double)c->raw_bytes / (double)c->file_bytes;
}

/* Encodes; with `decode` also decodes and measures. */
static int try_step(cvol_compression *c, double step, int decode)
{
    int code = cvol_attempt_encode(c->context, &c->attempt, step);
    if (!code && decode)
        code = cvol_attempt_decode(c->context, &c->attempt);
    c->file_bytes = c->attempt.bytes;
    return code;
}

/* Makes the complete array of a step. */
static int commit_step(cvol_compression *c, double step)
{
    const double weight = c->attempt.weight;
    int code = CVOL_OK;
    c->attempt.weight = c->best_weight;
    if ((!c->attempt.coded && !c->attempt.array) || c->attempt.step != step ||
        weight != c->best_weight)
        code = try_step(c, step, 1);
    else if (!c->attempt.array)
        code = cvol_attempt_decode(c->context, &c->attempt);
    if (!code && cvol_array_may_have_ranges(c->attempt.array, c->attempt.result.bytes))
        code = cvol_ranges_find(c->context, c->attempt.array);
    if (!code && c->attempt.coded) {
        cvol_coded_attach(c->attempt.array, c->attempt.coded);
        c->attempt.coded = NULL;
    }
    if (!code)
        code = cvol_array_file_bytes(c->context, c->attempt.array, &c->file_bytes);
    if (!code) /* the next estimates are as good as this */
        c->attempt.front_bytes = c->file_bytes - c->attempt.result.bytes;
    return code;
}

/* Estimates the step. If it is so fine that a mask saves nothing, starts again with the plain
 * samples. */
static int prepare(cvol_compression *c, double *step)
{
    int code = cvol_compression_prepare(c, step);
    if (code || *step >= c->attempt.least_step)
        return code;
    const void *samples = c->attempt.truth;
    const cvol_grid grid = c->attempt.shape->grid;
    cvol_attempt_free(&c->attempt);
    code = cvol_attempt_start(c->context, &c->attempt, samples, &grid, c->options);
    if (code)
        return code;
    cvol_attempt_set_options(&c->attempt, c->options);
    c->attempt.uncounted = 1;
    cvol_compression_limits(c);
    return cvol_compression_prepare(c, step);
}

typedef struct ratio_search {
    cvol_compression *c;
    double aim, accepted;
    int is_sure; /* the best step's file size is known, not only estimated */
} ratio_search;

static int try_ratio(void *user, int number, double step, double *miss,
                     cvol_search_verdict *verdict)
{
    ratio_search *search = user;
    cvol_compression *c = search->c;
    (void)number;
    int code = try_step(c, step, 0);
    const uint64_t estimated = c->file_bytes;
    const int commits = ratio_of(c) >= c->value * 0.9995 &&
                        ratio_of(c) <= c->value * CVOL_RATIO_MAX;
    if (!code && commits)
        code = commit_step(c, step);
    if (code)
        return code;
    /* Misses found with a wrong estimate mislead. */
    if (fabs((double)c->file_bytes - (double)estimated) > 1e-3 * (double)estimated) {
        *verdict = CVOL_SEARCH_FORGET;
        c->best_step = search->is_sure ? c->best_step : 0;
    }
    const double ratio = ratio_of(c);
    if (ratio >= c->value && (c->best_step <= 0 || step < c->best_step)) {
        c->best_step = step;
        search->is_sure = commits;
    }
    if (ratio >= c->value && ratio <= c->value * search->accepted)
        *verdict = CVOL_SEARCH_ENOUGH;
    *miss = cvol_log(ratio / c->value / search->aim);
    return CVOL_OK;
}

static int search_ratio(cvol_compression *c)
{
    static const cvol_search_plan plan = {.attempts_max = ATTEMPTS_MAX, .width = FINEST_WIDTH};
    double step;
    const int code = prepare(c, &step);
    if (code)
        return code;
    const int small = cvol_grid_samples(&c->attempt.shape->grid) < SMALL_SAMPLES;
    const int smallest = cvol_coding_of(c->attempt.shape)->neural;
    ratio_search ratios = {.c = c,
                           .aim = smallest ? MAX_EFFORT_RATIO_AIM
                                  : small  ? SMALL_RATIO_AIM
                                           : CVOL_RATIO_AIM,
                           .accepted = smallest ? MAX_EFFORT_RATIO_ACCEPTED
                                       : small  ? SMALL_RATIO_ACCEPTED
                                                : CVOL_RATIO_ACCEPTED};
    cvol_search search = cvol_search_make(c->least_step, c->most_step, 1.1);
    c->best_step = 0;
    return cvol_search_run(&search, &step, &plan, try_ratio, &ratios);
}

typedef struct weight_search {
    cvol_compression *c;
    double step, over; /* over: the best PSNR so far above the target */
} weight_search;

static int try_weight(void *user, int number, double weight, double *miss,
                      cvol_search_verdict *verdict)
{
    weight_search *search = user;
    cvol_compression *c = search->c;
    (void)number;
    c->attempt.weight = weight;
    const int code = try_step(c, search->step, 1);
    if (code)
        return code;
    const double now = c->attempt.array->psnr_db - c->value;
    if (now >= 0 && now < search->over) {
        search->over = now;
        c->best_step = search->step;
        c->best_weight = weight;
    }
    if (search->over < CVOL_PSNR_ACCEPTED)
        *verdict = CVOL_SEARCH_ENOUGH;
    *miss = (CVOL_PSNR_AIM - now) / CVOL_DB_PER_E;
    return CVOL_OK;
}

/* In small volumes single values count, and a PSNR may jump where a step passes them. At steps
 * finer than the jump, a larger weight of bits may come nearer. `over`: PSNR above the target so
 * far. */
static int search_weight(cvol_compression *c, double step, double over)
{
    static const cvol_search_plan plan = {.attempts_max = WEIGHTS_MAX, .width = WEIGHT_WIDTH};
    weight_search weights = {c, step, over};
    for (int i = 0; i < FINER_MAX && weights.over >= CVOL_PSNR_ACCEPTED;
         i++, weights.step *= FINER) {
        cvol_search search = cvol_search_make(1, WEIGHT_MAX, 0.3);
        double weight = FIRST_WEIGHT;
        const int code = cvol_search_run(&search, &weight, &plan, try_weight, &weights);
        if (code)
            return code;
    }
    return CVOL_OK;
}

typedef struct psnr_search {
    cvol_compression *c;
    double aim, most; /* accepted: the target up to `most` */
    double best;      /* the PSNR of c->best_step */
    int is_accepted;
} psnr_search;

static int try_psnr(void *user, int number, double step, double *miss, cvol_search_verdict *verdict)
{
    psnr_search *search = user;
    cvol_compression *c = search->c;
    (void)number;
    const int code = try_step(c, step, 1);
    if (code)
        return code;
    const double psnr = c->attempt.array->psnr_db, over = psnr - c->value - search->aim;
    if (psnr >= c->value && step > c->best_step) {
        c->best_step = step;
        search->best = psnr;
    }
    search->is_accepted = psnr >= c->value && psnr < search->most;
    if (search->is_accepted)
        *verdict = CVOL_SEARCH_ENOUGH;
    *miss = -(over > 30 ? 30 : over) / CVOL_DB_PER_E;
    return CVOL_OK;
}

static int search_psnr(cvol_compression *c)
{
    static const cvol_search_plan plan = {.attempts_max = ATTEMPTS_MAX, .width = FINEST_WIDTH};
    double step;
    int code = prepare(c, &step);
    if (code)
        return code;
    const int smallest = cvol_coding_of(c->attempt.shape)->neural;
    psnr_search psnrs = {.c = c,
                         .aim = c->attempt.fast ? CVOL_PSNR_FAST_AIM
                                : smallest      ? MAX_EFFORT_PSNR_AIM
                                                : CVOL_PSNR_AIM,
                         .most = c->value + (c->attempt.fast ? CVOL_PSNR_FAST_MORE
                                             : smallest      ? MAX_EFFORT_PSNR_ACCEPTED
                                                             : CVOL_PSNR_ACCEPTED)};
    cvol_search search = cvol_search_make(c->least_step, c->most_step, 0.8);
    c->best_step = 0;
    code = cvol_search_run(&search, &step, &plan, try_psnr, &psnrs);
    if (!code && !psnrs.is_accepted && !c->attempt.fast &&
        psnrs.best >= c->value + CVOL_PSNR_ACCEPTED && cvol_search_width(&search) < FINEST_WIDTH)
        code = search_weight(c, c->best_step * FINER, psnrs.best - c->value);
    return code;
}

/* ---- to a target ------------------------------------------------------------------------ */

static int is_met(const cvol_compression *c)
{
    return ratio_of(c) >= c->value && ratio_of(c) <= c->value * CVOL_RATIO_MAX;
}

static int run_ratio(cvol_compression *c, int *reached)
{
    int code = search_ratio(c);
    if (code)
        return code;
    if (c->best_step <= 0) /* even all terms zero are too large */
        code = commit_step(c, c->most_step);
    else
        code = commit_step(c, c->best_step);
    if (code)
        return code;
    const int is_exact = !(c->attempt.array->max_error > 0);
    *reached = is_met(c) ||
               (ratio_of(c) >= c->value && (is_exact || c->best_step > c->least_step * 1.000001));
    return code;
}

static int run_psnr(cvol_compression *c)
{
    int code = search_psnr(c);
    if (code)
        return code;
    if (c->best_step > 0)
        return commit_step(c, c->best_step);
    cvol_array_free(cvol_attempt_take_array(&c->attempt));
    return CVOL_OK;
}

static int run(cvol_compression *c, int *reached)
{
    *reached = 1;
    if (!(c->attempt.shape->error_bound.value_max >
          c->attempt.shape->error_bound.value_min)) { /* constant */
        int code = commit_step(c, 1);
        *reached = c->target != CVOL_TARGET_RATIO || ratio_of(c) >= c->value;
        return code;
    }
    cvol_compression_limits(c);
    return c->target == CVOL_TARGET_RATIO ? run_ratio(c, reached) : run_psnr(c);
}

static void fill_report(cvol_compress_report *report, const cvol_compression *c, int reached)
{
    const cvol_array *array = c->attempt.array;
    *report = (cvol_compress_report){.ratio = ratio_of(c),
                                     .psnr_db = array->psnr_db,
                                     .max_error = array->max_error,
                                     .file_bytes = c->file_bytes,
                                     .lossless = array->max_error <= 0,
                                     .target_met = reached,
                                     .trials = c->attempt.count,
                                     .coefficients = array->coefficients};
    if (cvol_mask_is_background(array->mask)) {
        report->background_samples = cvol_mask_samples(array->mask);
        report->background = cvol_array_background(array);
    }
}

/* *mask_bytes: bytes of the background's mask in the file. *out is NULL if no step reaches the
 * PSNR. */
static int compress_terms(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                          uint64_t *mask_bytes, const void *samples, const cvol_grid *grid,
                          const cvol_compress_options *options)
{
    int code = CVOL_OK;
    cvol_compression c = {.context = context,
                          .options = options,
                          .target = options->target,
                          .value = options->target_value};
    int reached = 0;
    if (c.target == CVOL_TARGET_BITS) {
        c.target = CVOL_TARGET_RATIO;
        code = cvol_grid_check(context, grid, "array");
        if (!code)
            code = cvol_ratio_of_bits(context, &c.value, options->target_value, grid->type);
    }
    if (!code)
        code = cvol_attempt_start_with_background(context, &c.attempt, samples, grid, options);
    if (!code)
        cvol_attempt_set_options(&c.attempt, options);
    if (!code) {
        c.raw_bytes = cvol_grid_bytes(grid);
        c.attempt.uncounted = 1;
        code = run(&c, &reached);
    }
    if (!code && c.attempt.array) {
        fill_report(report, &c, reached);
        *mask_bytes = report->background_samples ? c.attempt.mask_bytes : 0;
        *out = cvol_attempt_take_array(&c.attempt);
    }
    cvol_attempt_free(&c.attempt);
    return code;
}

/* ---- with a background and without -------------------------------------------------------- */

typedef struct second_half {
    cvol_progress_fn progress;
    void *user;
} second_half;

static int report_second_half(void *user, const char *stage, double fraction)
{
    const second_half *at = user;
    return at->progress(at->user, stage, 0.9 + 0.1 * fraction);
}

static int is_better(cvol_target target, const cvol_compress_report *a,
                     const cvol_compress_report *b)
{
    if (a->target_met != b->target_met)
        return a->target_met;
    return target == CVOL_TARGET_PSNR ? a->file_bytes < b->file_bytes : a->psnr_db > b->psnr_db;
}

/* Keeps the smaller of the arrays with and without a separate background. */
static int try_without(cvol_context *context, cvol_array **array, cvol_compress_report *report,
                       const void *samples, const cvol_grid *grid,
                       const cvol_compress_options *options)
{
    cvol_compress_options plain = *options;
    plain.background = CVOL_BACKGROUND_NONE;
    cvol_array *without = NULL;
    cvol_compress_report of_it;
    uint64_t none;
    second_half at = {context->progress, context->progress_user};
    if (at.progress)
        cvol_context_set_progress(context, report_second_half, &at);
    const int code = compress_terms(context, &without, &of_it, &none, samples, grid, &plain);
    cvol_context_set_progress(context, at.progress, at.user);
    if (code || !without)
        return code;
    of_it.trials += report->trials;
    report->trials = of_it.trials;
    if (is_better(options->target, &of_it, report)) {
        cvol_array_free(*array);
        *array = without;
        *report = of_it;
    } else {
        cvol_array_free(without);
    }
    return CVOL_OK;
}

int cvol_compress_terms(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                        const void *samples, const cvol_grid *grid,
                        const cvol_compress_options *options)
{
    uint64_t mask_bytes = 0;
    const double sure = options->target == CVOL_TARGET_PSNR ? MASK_SHARE_SURE_OF_PSNR
                                                            : MASK_SHARE_SURE;
    *out = NULL;
    int code = compress_terms(context, out, report, &mask_bytes, samples, grid, options);
    if (!code && *out && options->background == CVOL_BACKGROUND_FIND &&
        (double)mask_bytes > sure * (double)report->file_bytes)
        code = try_without(context, out, report, samples, grid, options);
    if (code) {
        cvol_array_free(*out);
        *out = NULL;
    }
    return code;
}
