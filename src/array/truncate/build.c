/* The builder: the limit of a keep, passes over all blocks, and the runs joined in order. */
#include "array/truncate/build.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/share.h"
#include "array/truncate/build_runs.h"
#include "array/truncate/producer.h"
#include "array/truncate/result_block.h"
#include "base/context.h"
#include "base/memory.h"
#include "transform/cell.h"

enum { RUN_TERMS = 1 << 17, FINE_BITS = 22, FINEST_BITS = 28, ALL_BITS = 29 };

/* Terms below this share of a step become zero: they are many, and a zero takes few bits. */
#define DEAD_ZONE 0.6
/* About the same share where isolated coefficients are dropped. */
#define MEAN_DEAD_ZONE 0.65
/* The step within an allowed loss follows from every COUNTED-th run, of at least COUNT_ALL runs,
 * and is corrected if the loss was larger. */
enum { COUNTED = 4, COUNT_ALL = 32, TRIES = 4 };
/* The share of the allowed loss at which the step aims, so that few steps need correction; at least
 * USED is used, or other steps are tried. */
#define AIM 0.96
#define USED 0.9
/* The first other threshold of isolated coefficients that is tried. */
#define ISOLATED_NEXT 1.0

/* A power of two: see build.h. */
static double fine_step(const cvol_array *array, const cvol_keep *keep)
{
    const double terms = (double)cvol_array_block_terms(array);
    const double bound = cvol_array_coefficient_bound(array);
    if (!(bound > 0) || !isfinite(bound))
        return 1;
    int exponent;
    (void)frexp(bound, &exponent);
    double step = ldexp(1, exponent - FINE_BITS);
    if (keep->rule == CVOL_KEEP_L2 || keep->rule == CVOL_KEEP_PSNR) {
        const double all = sqrt(terms * (double)array->block_count);
        const double finest = ldexp(1, exponent - CVOL_MAX_BITS + 1);
        while (step > finest && step * all > cvol_select_allowed(array, keep))
            step /= 2;
    }
    return step;
}

/* The step for ALL: by the largest coefficient itself, which may be far below any bound. */
static double step_for_all(const cvol_bins *bins, double otherwise)
{
    size_t top = CVOL_BINS;
    while (top && !bins->bins[top - 1].count)
        top--;
    const uint32_t bits = (uint32_t)(top << CVOL_BIN_SHIFT); /* above all keys */
    float largest;
    memcpy(&largest, &bits, sizeof largest);
    if (!top || !isfinite(largest))
        return otherwise;
    int exponent;
    (void)frexp(1.5 * (double)largest, &exponent); /* DFT: a slot is at most sqrt(2) keys */
    return ldexp(1, exponent - ALL_BITS);
}

/* Blocks are evaluated with the step in single precision. The loss of a step that single precision
 * can hold is counted; the loss of a smaller step is not. */
static double at_least_float(double step)
{
    return fmax(step, (double)FLT_MIN);
}

/* The smallest float that is not below `value`, and positive. */
static float float_above(double value)
{
    float f = (float)value;
    if ((double)f < value)
        f = nextafterf(f, INFINITY);
    return f > 0 ? f : 1e-45f;
}

static int make_forced(cvol_context *context, cvol_builder *b, const cvol_keep *keep)
{
    const cvol_array *array = b->array;
    if (keep->rule == CVOL_KEEP_ALL || (!keep->low[0] && !keep->low[1] && !keep->low[2]))
        return CVOL_OK;
    b->forced = cvol_allocate_zero(b->per_block, 1);
    if (!b->forced)
        return cvol_fail_memory(context, b->per_block, "the low box");
    const size_t mask = (size_t)array->block - 1;
    for (size_t p = 0; p < b->per_block; p++) {
        b->forced[p] = 1;
        for (int a = 0; a < array->rank; a++) {
            size_t u = p >> a * array->block_log2 & mask;
            if (array->transform != CVOL_DCT && 2 * u > mask + 1)
                u = mask + 1 - u;
            b->forced[p] = b->forced[p] && u < (keep->low[a] ? keep->low[a] : 1);
        }
    }
    return CVOL_OK;
}

/* The bytes of the array without terms, including all of its pools. */
static uint64_t base_bytes(const cvol_builder *b)
{
    cvol_array_info info;
    cvol_array_get_info(&info, b->array);
    size_t capacity = b->array->pool_capacity;
    while (capacity < b->run_count)
        capacity = 2 * capacity + 16;
    return info.resident_bytes + (capacity - b->array->pool_capacity) * sizeof(uint32_t *);
}

/* ---- the coarsest step within an allowed loss ------------------------------------------------ */

static void clear_runs(cvol_builder *b)
{
    for (size_t r = 0; r < b->run_count; r++) {
        free(b->runs[r].terms);
        free(b->runs[r].candidates);
    }
    memset(b->runs, 0, b->run_count * sizeof *b->runs);
}

static double lost_in(const cvol_builder *b)
{
    double lost = 0;
    for (size_t r = 0; r < b->run_count; r++)
        lost += b->runs[r].lost;
    return sqrt(lost);
}

static int find_step(cvol_context *context, cvol_builder *b, double *step, double allowed)
{
    cvol_bins bins;
    if (!cvol_bins_make(&bins))
        return cvol_fail_memory(context, CVOL_BINS * sizeof(cvol_bin), "a histogram");
    b->counting = &bins;
    b->counted = b->run_count < COUNT_ALL ? 1 : COUNTED;
    const int code = cvol_build_pass(context, b, 0, 0.4);
    b->counting = NULL;
    *step = b->expected_step = cvol_select_step(&bins, AIM * allowed / sqrt((double)b->counted),
                                                b->drops_isolated ? MEAN_DEAD_ZONE : DEAD_ZONE);
    cvol_bins_free(&bins);
    return code;
}

static int run_passes(cvol_context *context, cvol_builder *b, const cvol_keep *keep);

/* One pass that quantizes to this step. */
static int quantize(cvol_context *context, cvol_builder *b, double step, double isolated)
{
    b->array->step = b->step = b->expected_step = at_least_float(step);
    b->least = float_above((b->drops_isolated ? CVOL_LEAST_ONE : DEAD_ZONE) * b->step);
    b->isolated = isolated;
    clear_runs(b);
    return cvol_build_pass(context, b, 0.4, 1);
}

/* Coefficients of sums have few values, multiples of the steps of the operands, so the loss jumps
 * with the step. Here the runs hold terms of a step that loses `lost`, much less than allowed: more
 * of the isolated coefficients vanish, until the loss is about the allowed one. */
static int use_rest(cvol_context *context, cvol_builder *b, double lost, double allowed)
{
    const double step = b->step, wanted = AIM * allowed;
    double least = CVOL_ISOLATED, least_lost = lost, most = 0, most_lost = 0, next = ISOLATED_NEXT;
    for (int tries = 0; tries < TRIES; tries++) {
        const int code = quantize(context, b, step, next);
        lost = lost_in(b);
        if (code || (lost <= allowed && lost >= USED * allowed))
            return code;
        *(lost <= allowed ? &least : &most) = next;
        *(lost <= allowed ? &least_lost : &most_lost) = lost;
        if (most > 0) {
            const double share = (wanted * wanted - least_lost * least_lost) /
                                 (most_lost * most_lost - least_lost * least_lost);
            next = least + fmin(fmax(share, 0.1), 0.9) * (most - least);
        } else {
            next *= ISOLATED_NEXT / CVOL_ISOLATED;
        }
    }
    return lost <= allowed ? CVOL_OK : quantize(context, b, step, least);
}

/* Keeps all terms if no step of a few tries loses as little as that. */
static int quantize_within(cvol_context *context, cvol_builder *b, double allowed)
{
    const double finest = ldexp(cvol_array_coefficient_bound(b->array), -FINEST_BITS);
    const cvol_keep all = cvol_keep_all();
    double step = 0;
    b->expected_step = cvol_result_expected_step(b->array, allowed);
    int code = find_step(context, b, &step, allowed);
    for (int tries = 0; !code && step >= finest && tries < TRIES; tries++) {
        code = quantize(context, b, step, CVOL_ISOLATED);
        const double lost = lost_in(b);
        if (!code && b->drops_isolated && lost > 0 && lost < USED * allowed)
            return use_rest(context, b, lost, allowed);
        if (code || !(lost > allowed))
            return code;
        step *= AIM * allowed / lost; /* the loss grows no faster than the step */
    }
    clear_runs(b);
    b->expected_step = 0;
    b->hides = b->drops_isolated = 0;
    return code ? code : run_passes(context, b, &all);
}

/* A PSNR over a range of 0, that of constant samples: keeps all terms, as whole arrays do. */
static int is_all(const cvol_array *array, const cvol_keep *keep)
{
    const cvol_error_bound *error_bound = &array->error_bound;
    return keep->rule == CVOL_KEEP_ALL ||
           (keep->rule == CVOL_KEEP_PSNR && !(error_bound->value_max > error_bound->value_min));
}

/* Runs the passes; the runs then hold the terms. */
static int run_passes(cvol_context *context, cvol_builder *b, const cvol_keep *keep)
{
    const cvol_keep all = cvol_keep_all();
    cvol_array *array = b->array;
    keep = is_all(array, keep) ? &all : keep;
    array->threshold = 0;
    b->step = at_least_float(keep->rule == CVOL_KEEP_STEP ? keep->value : fine_step(array, keep));
    array->step = b->step;
    switch (keep->rule) {
    case CVOL_KEEP_STEP:
        b->expected_step = b->step;
        b->least = float_above(DEAD_ZONE * b->step);
        break;
    case CVOL_KEEP_LOSS:
        return quantize_within(context, b, keep->value);
    case CVOL_KEEP_THRESHOLD:
        b->least = float_above(fmax(keep->value, b->step / 2));
        array->threshold = keep->value;
        break;
    default: {
        cvol_bins bins;
        cvol_selection selection;
        if (keep->rule != CVOL_KEEP_ALL && cvol_share_of(context, array).team)
            return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                             "%s: several processes keep all terms, quantize with a step, or lose "
                             "what the operands allow; other truncations need one process",
                             b->producer->what);
        if (!cvol_bins_make(&bins))
            return cvol_fail_memory(context, CVOL_BINS * sizeof(cvol_bin), "a histogram");
        b->counting = &bins;
        b->counted = 1;
        int code = cvol_build_pass(context, b, 0, 0.4);
        b->counting = NULL;
        if (!code && keep->rule == CVOL_KEEP_ALL) {
            array->step = b->step = at_least_float(step_for_all(&bins, b->step));
            b->least = float_above(b->step / 2);
            cvol_bins_free(&bins);
            return cvol_build_pass(context, b, 0.4, 1);
        }
        if (!code)
            code = cvol_select(context, &selection, array, keep, &bins, base_bytes(b));
        cvol_bins_free(&bins);
        if (code)
            return code;
        b->least = selection.least;
        b->critical = selection.critical;
        array->threshold = isinf(selection.critical) ? 0 : (double)selection.critical;
        code = cvol_build_pass(context, b, 0.4, 1);
        return code ? code : cvol_build_commit(context, b, &selection);
    }
    }
    return cvol_build_pass(context, b, 0, 1);
}

/* Moves the runs' terms and sums to the array and the result. */
static int hand_over(cvol_context *context, cvol_builder *b, cvol_build_result *result,
                     int is_default)
{
    cvol_array *array = b->array;
    double lost = 0, norm = 0, worst = 0;
    array->coefficients = 0;
    for (size_t r = 0; r < b->run_count; r++) {
        cvol_build_run *one = &b->runs[r];
        lost += one->lost;
        norm += one->norm;
        worst = fmax(worst, one->worst_point);
        result->max_abs = one->max_abs < 0 || result->max_abs < 0
                              ? -1
                              : fmax(result->max_abs, (double)one->max_abs);
        array->coefficients += one->coefficients;
        if (!one->terms)
            continue;
        int code = cvol_array_adopt_pool(context, array, one->terms, one->words);
        if (code)
            return code;
        one->terms = NULL;
    }
    if (b->hides && array->mask && result->max_abs >= 0)
        result->max_abs = fmax(result->max_abs, fabs(cvol_array_background(array)));
    result->dropped = sqrt(lost);
    result->is_default = is_default;
    result->norm = sqrt(norm);
    result->sample = worst;
    return CVOL_OK;
}

int cvol_build_blocks(cvol_context *context, cvol_array *array, cvol_build_result *result,
                      const cvol_producer *producer, const cvol_keep *keep)
{
    cvol_builder b = {
        .array = array, .producer = producer, .per_block = cvol_array_block_terms(array)};
    memset(result, 0, sizeof *result);
    if (keep->rule == CVOL_KEEP_LIKE_INPUTS ||
        ((keep->rule == CVOL_KEEP_STEP || keep->rule == CVOL_KEEP_LOSS) &&
         !(keep->value > 0 && isfinite(keep->value))))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: keep rule %d, or its value %g, cannot be used here", producer->what,
                         (int)keep->rule, keep->value);
    b.hides = keep->rule == CVOL_KEEP_LOSS && cvol_array_is_volume(array);
    b.drops_isolated = b.hides && array->block == CVOL_CELL;
    b.run_blocks = RUN_TERMS / b.per_block ? RUN_TERMS / b.per_block : 1;
    b.run_count = (array->block_count - 1) / b.run_blocks + 1;
    b.runs = cvol_allocate_zero(b.run_count, sizeof *b.runs);
    if (!b.runs)
        return cvol_fail_memory(context, b.run_count * sizeof *b.runs, producer->what);
    int code = make_forced(context, &b, keep);
    if (!code)
        code = run_passes(context, &b, keep);
    if (!code)
        code = hand_over(context, &b, result, keep->rule == CVOL_KEEP_LOSS);
    clear_runs(&b);
    free(b.runs);
    free(b.forced);
    return code ? code : cvol_report_progress(context, producer->what, 1);
}
