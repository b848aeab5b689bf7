/* Compressing to a target: the search for the step.
 *
 * A miss (search.h) is a difference of logarithms: of the ratio and the asked one, of the errors,
 * or of PSNR in units of a factor e. Sizes are estimated on a few groups first where there are
 * many.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "codec/search.h"
#include "codec/trial.h"

/* What the searches aim at within what is allowed: 2 % of ratio, 0.1 dB, 2 % of step. */
#define RATIO_AIM 1.004
#define RATIO_ACCEPTED 1.012
#define RATIO_MOST 1.02
#define PSNR_AIM 0.03
#define PSNR_ACCEPTED 0.08
#define ERROR_WIDTH 0.015
#define FINEST_WIDTH 2e-4
/* Where a ratio's search begins, in units of the samples' range, per unit of ratio. */
#define FIRST_STEP 6e-4
/* Of a step below this, rounding to integers may give back the exact samples. */
#define EXACT_STEP 1.5
#define DB_PER_E (20 / 2.302585092994046)

enum { TRIALS_MOST = 60, SAMPLED_GROUPS = 6 };

cvol_compress_options cvol_compress_options_defaults(void)
{
    return (cvol_compress_options){
        .transform = CVOL_DCT, .block = 16, .target = CVOL_TARGET_RATIO, .target_value = 30};
}

static int check_options(cvol_context *context, const cvol_compress_options *options)
{
    const double value = options->target_value;
    if (options->transform != CVOL_DCT)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "transform %d cannot be compressed to; there is 1 (dct)",
                         (int)options->transform);
    if (options->block != 8 && options->block != 16 && options->block != 32)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "block is %d, must be 8, 16 or 32",
                         options->block);
    switch (options->target) {
    case CVOL_TARGET_BITS:
        if (!(value > 0) || !isfinite(value))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT, "bits a sample are %g, must be above 0",
                             value);
        return CVOL_OK;
    case CVOL_TARGET_RATIO:
        if (!(value > 1) || !isfinite(value))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT, "ratio is %g, must be above 1", value);
        return CVOL_OK;
    case CVOL_TARGET_PSNR:
        if (!(value > 0) || !(value <= 200))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "PSNR is %g dB, must be above 0 and at most 200", value);
        return CVOL_OK;
    case CVOL_TARGET_MAX_ERROR:
        if (!(value >= 0) || !isfinite(value))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT, "maximum error is %g, must be 0 or more",
                             value);
        return CVOL_OK;
    }
    return cvol_fail(context, CVOL_ERROR_ARGUMENT, "target %d is none", (int)options->target);
}

/* Bits a sample, as the ratio that they are. */
static int ratio_of_bits(cvol_context *context, double *ratio, double bits, cvol_type type)
{
    const double raw = 8 * (double)cvol_type_size(type);
    if (!(bits < raw) || !isfinite(raw / bits))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "bits a sample are %g, must be above 0 and below the %g of %s samples",
                         bits, raw, cvol_type_name(type));
    *ratio = raw / bits;
    return CVOL_OK;
}

/* ---- the search ------------------------------------------------------------------------- */

/* The state of one cvol_compress. */
typedef struct compression {
    cvol_context *context;
    cvol_trial trial;
    cvol_target target;
    double value;
    uint64_t raw_bytes, file_bytes;
    double least_step, most_step;
    double best_step; /* the best that keeps the target, 0: none yet */
    double reached;   /* the best PSNR or error found, for the message if none keeps it */
} compression;

static double ratio_of(const compression *c)
{
    return (double)c->raw_bytes / (double)c->file_bytes;
}

/* Encodes, and decodes unless only the size matters. */
static int try_step(compression *c, double step, int decode)
{
    cvol_array_free(c->trial.array); /* of another step */
    c->trial.array = NULL;
    int code = cvol_trial_encode(c->context, &c->trial, step, 1);
    (void)decode; /* the file is of another coder than the trial: what it takes is known from terms */
    if (!code)
        code = cvol_trial_decode(c->context, &c->trial);
    if (!code)
        code = cvol_trial_finish(c->context, &c->trial, &c->file_bytes);
    return code;
}

/* Makes the array of a step, whole. */
static int settle(compression *c, double step)
{
    int code = CVOL_OK;
    if (c->trial.step != step)
        code = try_step(c, step, 1);
    else if (!c->trial.array)
        code = cvol_trial_decode(c->context, &c->trial);
    if (!code)
        code = cvol_trial_finish(c->context, &c->trial, &c->file_bytes);
    return code;
}

/* Finds about where the step lies by encoding a few groups. */
static int sample_ratio(compression *c, cvol_search *search)
{
    const size_t stride = cvol_group_count(c->trial.shape) / SAMPLED_GROUPS;
    cvol_search sampled = *search;
    double step = c->best_step;
    if (stride < 2)
        return CVOL_OK;
    for (int i = 0; i < 8; i++) {
        int code = cvol_trial_encode(c->context, &c->trial, step, stride);
        if (code)
            return code;
        size_t groups = 0;
        uint64_t bytes = 0;
        for (size_t g = stride / 2; g < c->trial.groups.count; g += stride, groups++)
            bytes += c->trial.groups.bytes[g].size;
        double share = (double)c->trial.groups.count / (double)groups;
        double miss = log((double)c->raw_bytes / c->value / RATIO_AIM /
                          ((double)c->trial.begin_bytes + (double)bytes * share));
        cvol_search_tell(&sampled, step, miss);
        step = cvol_search_next(&sampled);
        if (fabs(miss) < 0.03 || cvol_search_at_least(&sampled) || cvol_search_at_most(&sampled))
            break;
    }
    search->slope = sampled.slope;
    c->best_step = step;
    return CVOL_OK;
}

static int search_ratio(compression *c)
{
    cvol_search search = cvol_search_make(c->least_step, c->most_step, 1.1);
    const double span = c->trial.shape->ledger.value_max - c->trial.shape->ledger.value_min;
    double step = fmin(fmax(span * FIRST_STEP * c->value, c->least_step), c->most_step);
    c->best_step = step;
    int code = sample_ratio(c, &search);
    step = c->best_step;
    c->best_step = 0;
    for (int i = 0; i < TRIALS_MOST && !code; i++) {
        code = try_step(c, step, 0);
        const uint64_t estimated = c->file_bytes;
        if (!code && ratio_of(c) >= c->value * 0.99 && ratio_of(c) <= c->value * RATIO_MOST)
            code = settle(c, step);
        if (code)
            return code;
        /* What was told with a wrong estimate misleads. */
        if (fabs((double)c->file_bytes - (double)estimated) > 1e-3 * (double)estimated)
            search = cvol_search_make(c->least_step, c->most_step, search.slope);
        const double ratio = ratio_of(c);
        if (ratio >= c->value && (c->best_step <= 0 || step < c->best_step))
            c->best_step = step;
        if (ratio >= c->value && ratio <= c->value * RATIO_ACCEPTED)
            break;
        cvol_search_tell(&search, step, log(ratio / c->value / RATIO_AIM));
        if (cvol_search_at_least(&search) || cvol_search_at_most(&search) ||
            cvol_search_width(&search) < FINEST_WIDTH)
            break;
        step = cvol_search_next(&search);
    }
    return code;
}

/* How far a measured array misses a PSNR or an error; `kept`: the target holds. */
static double miss_of_quality(const compression *c, int *kept)
{
    const cvol_array *array = c->trial.array;
    if (c->target == CVOL_TARGET_PSNR) {
        *kept = array->psnr_db >= c->value;
        double over = array->psnr_db - c->value - PSNR_AIM;
        return -(over > 30 ? 30 : over) / DB_PER_E;
    }
    *kept = array->max_error <= c->value;
    /* Errors of integers come in steps of one. */
    double grain = cvol_type_is_integer(array->grid.type) ? 0.5 : 1e-3 * c->value;
    double aim = cvol_type_is_integer(array->grid.type) ? floor(c->value) + 0.25 : c->value * 0.99;
    return log((array->max_error + grain) / (aim + grain));
}

static int search_quality(compression *c)
{
    cvol_search search = cvol_search_make(c->least_step, c->most_step, 0.8);
    const double span = c->trial.shape->ledger.value_max - c->trial.shape->ledger.value_min;
    double step = c->target == CVOL_TARGET_PSNR ? 3 * span * exp(-c->value / DB_PER_E)
                                                : 1.5 * (c->value > 0 ? c->value : 0.4);
    step = fmin(fmax(step, c->least_step), c->most_step);
    c->best_step = 0;
    c->reached = c->target == CVOL_TARGET_PSNR ? 0 : span;
    for (int i = 0; i < TRIALS_MOST; i++) {
        int kept, code = try_step(c, step, 1);
        if (code)
            return code;
        const double miss = miss_of_quality(c, &kept);
        if (c->target == CVOL_TARGET_PSNR)
            c->reached = fmax(c->reached, c->trial.array->psnr_db);
        else
            c->reached = fmin(c->reached, c->trial.array->max_error);
        if (kept && step > c->best_step)
            c->best_step = step;
        if (kept && c->target == CVOL_TARGET_PSNR &&
            c->trial.array->psnr_db < c->value + PSNR_ACCEPTED)
            break;
        cvol_search_tell(&search, step, miss);
        if (cvol_search_at_least(&search) || cvol_search_at_most(&search) ||
            cvol_search_width(&search) <
                (c->target == CVOL_TARGET_PSNR ? FINEST_WIDTH : ERROR_WIDTH))
            break;
        step = cvol_search_next(&search);
    }
    return CVOL_OK;
}

/* ---- cvol_compress ---------------------------------------------------------------------- */

/* The steps that make sense: from exact (integers) or what float arithmetic can hold, to all zero.
 */
static void find_limits(compression *c)
{
    const cvol_array *shape = c->trial.shape;
    const double largest = (double)c->trial.coefficients.largest;
    const double span = shape->ledger.value_max - shape->ledger.value_min;
    double least = span * 0x1p-23;
    if (cvol_type_is_integer(shape->grid.type)) {
        /* Errors of at most step / 2 in each of B^3 coefficients sum up to less than 1/2. */
        const double exact = 0.99 / pow(shape->block, 1.5);
        least = least < exact ? exact : least;
    }
    if (least < largest * 0x1.01p-30)
        least = largest * 0x1.01p-30;
    c->least_step = least;
    c->most_step = fmax(2.01 * largest, 2 * least);
}

/* Finds the largest step that gives integers back exactly, *step = 0 if there is none. */
static int find_exact(compression *c, double *step)
{
    *step = 0;
    if (!cvol_type_is_integer(c->trial.shape->grid.type))
        return CVOL_OK;
    compression exact = *c;
    exact.target = CVOL_TARGET_MAX_ERROR;
    exact.value = 0;
    exact.trial.plain = 1;
    int code = search_quality(&exact);
    c->trial = exact.trial;
    *step = exact.best_step;
    return code;
}

static int is_met(const compression *c)
{
    return ratio_of(c) >= c->value && ratio_of(c) <= c->value * RATIO_MOST;
}

/* The step for the ratio is so fine that the exact samples may cost no more. */
static int settle_fine(compression *c)
{
    double step = 0;
    c->trial.plain = 1;
    /* Exact samples cost more the finer the step: if this one is not exact, none that is will do.
     */
    int code = try_step(c, c->best_step * 1.05, 1);
    if (!code && c->trial.array->max_error <= 0)
        code = find_exact(c, &step);
    if (!code && step > 0)
        code = settle(c, step);
    if (code || (step > 0 && ratio_of(c) >= c->value))
        return code;
    c->trial.plain = 0;
    c->trial.step = 0; /* encoded otherwise: again */
    return settle(c, c->best_step);
}

static int run_ratio(compression *c, int *met)
{
    int code = search_ratio(c);
    if (code)
        return code;
    if (c->best_step <= 0) /* even all zero is not small enough */
        code = settle(c, c->most_step);
    else if (c->best_step < EXACT_STEP && cvol_type_is_integer(c->trial.shape->grid.type))
        code = settle_fine(c);
    else
        code = settle(c, c->best_step);
    *met = is_met(c) || (ratio_of(c) >= c->value && c->best_step > c->least_step * 1.000001 &&
                         c->trial.array->max_error > 0);
    return code;
}

static int fail_quality(const compression *c)
{
    const char *type = cvol_type_name(c->trial.shape->grid.type);
    if (c->target == CVOL_TARGET_PSNR)
        return cvol_fail(c->context, CVOL_ERROR_TARGET,
                         "a PSNR of %g dB cannot be reached for these %s samples, %.2f dB can",
                         c->value, type, c->reached);
    return cvol_fail(c->context, CVOL_ERROR_TARGET,
                     "a maximum error of %g cannot be kept for these %s samples, %g can", c->value,
                     type, c->reached);
}

static int run_quality(compression *c)
{
    int code = search_quality(c);
    if (!code && c->best_step <= 0 && c->target == CVOL_TARGET_PSNR)
        code = find_exact(c, &c->best_step);
    if (code)
        return code;
    return c->best_step > 0 ? settle(c, c->best_step) : fail_quality(c);
}

static int run(compression *c, int *met)
{
    c->trial.plain = c->target == CVOL_TARGET_MAX_ERROR;
    *met = 1;
    if (c->trial.coefficients.largest <= 0) { /* constant */
        int code = settle(c, 1);
        *met = c->target != CVOL_TARGET_RATIO ||
               (ratio_of(c) >= c->value && ratio_of(c) <= c->value * RATIO_MOST);
        return code;
    }
    find_limits(c);
    return c->target == CVOL_TARGET_RATIO ? run_ratio(c, met) : run_quality(c);
}

static void fill_report(cvol_compress_report *report, const compression *c, int met)
{
    const cvol_array *array = c->trial.array;
    *report = (cvol_compress_report){.ratio = ratio_of(c),
                                     .psnr_db = array->psnr_db,
                                     .max_error = array->max_error,
                                     .file_bytes = c->file_bytes,
                                     .lossless = array->max_error <= 0,
                                     .target_met = met,
                                     .trials = c->trial.count};
}

int cvol_compress(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                  const void *samples, const cvol_grid *grid, const cvol_compress_options *options)
{
    *out = NULL;
    int code = check_options(context, options);
    if (code)
        return code;
    compression c = {.context = context, .target = options->target, .value = options->target_value};
    int met = 0;
    if (c.target == CVOL_TARGET_BITS) {
        c.target = CVOL_TARGET_RATIO;
        code = cvol_grid_check(context, grid, "array");
        if (!code)
            code = ratio_of_bits(context, &c.value, options->target_value, grid->type);
    }
    if (!code)
        code = cvol_trial_start(context, &c.trial, samples, grid, options->block);
    if (!code) {
        c.raw_bytes = cvol_grid_bytes(grid);
        code = run(&c, &met);
    }
    if (!code && report)
        fill_report(report, &c, met);
    if (!code)
        code = cvol_report_progress(context, "compressing", 1);
    if (!code) {
        *out = c.trial.array;
        c.trial.array = NULL;
    }
    cvol_trial_free(&c.trial);
    return code;
}
