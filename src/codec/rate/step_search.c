/* Searches for a step on samples of the volume. */
#include "codec/rate/step_search.h"

#include <math.h>

#include "base/context.h"
#include "base/elementary.h"
#include "codec/quantize/coding.h"
#include "transform/lap.h"

/* The start of a ratio's search, in units of the samples' range, per unit of ratio. */
#define FIRST_STEP 6e-4
/* Trellis quantization with this fraction of a step has about the same error. */
#define TRELLIS_STEP_SHARE 0.57
/* Below this number of bits per voxel, nearly all bits code DCs and single coefficients, and plain
 * rounding takes fewer: measured on four volumes. */
#define TRELLIS_BITS_MIN 0.028
/* Sampled misses that are good enough: usual; of the neural coder, whose passes take long; in
 * effort fast, first and last. */
#define SAMPLE_MISS 0.02
#define NEURAL_MISS 0.004
#define FAST_MISS 0.08
#define GUESS_MISS 0.03

/* Misses rise at most this much per factor e of step: cvol_search_plan.stale_slope. */
#define STALE_SLOPE 8

enum { SAMPLES_MAX = 8, FEW_OF_CELLS = 8 };

double cvol_compression_sample_miss(const cvol_compression *c)
{
    if (c->target == CVOL_TARGET_PSNR)
        return (c->value + (c->attempt.fast ? CVOL_PSNR_FAST_AIM : 0) -
                cvol_attempt_psnr(&c->attempt)) /
               CVOL_DB_PER_E;
    return cvol_log((double)c->raw_bytes / c->value / CVOL_RATIO_AIM / (double)c->attempt.bytes);
}

/* The start of the search. */
static double first_step(const cvol_compression *c)
{
    const double span = c->attempt.shape->error_bound.value_max -
                        c->attempt.shape->error_bound.value_min;
    const double plain = c->target == CVOL_TARGET_PSNR
                             ? 3 * span * cvol_exp(-c->value / CVOL_DB_PER_E)
                             : span * FIRST_STEP * c->value;
    const double step = plain *
                        (cvol_coding_of(c->attempt.shape)->trellis ? TRELLIS_STEP_SHARE : 1);
    return fmin(fmax(step, c->least_step), c->most_step);
}

/* The slope of misses for later searches: the sample search's, within limits. */
static double slope_of(const cvol_search *search)
{
    return fmin(fmax(cvol_search_slope(search), 0.5), STALE_SLOPE);
}

/* A search over samples of the volume. */
typedef struct sampling {
    cvol_compression *c;
    double enough; /* a smaller miss counts as none */
    int fits;      /* tables are fitted to the samples */
    size_t every;  /* one cell in this many */
} sampling;

static int try_sample(void *user, int number, double step, double *miss,
                      cvol_search_verdict *verdict)
{
    const sampling *s = user;
    cvol_compression *c = s->c;
    (void)number;
    int code = cvol_report_progress(c->context, "compressing", 0);
    if (!code)
        code = cvol_attempt_sample(c->context, &c->attempt, step);
    if (code)
        return code;
    *miss = cvol_compression_sample_miss(c);
    if (fabs(*miss) < s->enough)
        *verdict = CVOL_SEARCH_ENOUGH;
    return s->fits ? cvol_attempt_fit(c->context, &c->attempt) : CVOL_OK;
}

/* Estimates the step by encoding some bricks; with `fits`, fits the tables to them. */
static int sample_step(cvol_compression *c, double *step, double slope, int fits)
{
    const cvol_search_plan plan = {.attempts_max = SAMPLES_MAX, .stale_slope = STALE_SLOPE};
    sampling s = {.c = c,
                  .enough = c->attempt.fast                            ? FAST_MISS
                            : cvol_coding_of(c->attempt.shape)->neural ? NEURAL_MISS
                                                                       : SAMPLE_MISS,
                  .fits = fits};
    cvol_search search = cvol_search_make(c->least_step, c->most_step, slope);
    const int code = cvol_search_run(&search, step, &plan, try_sample, &s);
    if (!code)
        c->slope = slope_of(&search);
    return code;
}

static int try_guess(void *user, int number, double step, double *miss,
                     cvol_search_verdict *verdict)
{
    const sampling *s = user;
    cvol_compression *c = s->c;
    (void)number;
    int code = cvol_report_progress(c->context, "compressing", 0);
    if (!code)
        code = cvol_attempt_estimate_error(c->context, &c->attempt, step, s->every);
    if (code)
        return code;
    *miss = cvol_compression_sample_miss(c);
    if (fabs(*miss) < s->enough)
        *verdict = CVOL_SEARCH_ENOUGH;
    return CVOL_OK;
}

/* Finds the step with which cells from all over the volume have the target's error. */
static int guess_step(cvol_compression *c, double *step, size_t every, double enough)
{
    const cvol_search_plan plan = {.attempts_max = SAMPLES_MAX};
    sampling s = {.c = c, .enough = enough, .every = every};
    cvol_search search = cvol_search_make(c->least_step, c->most_step, c->slope);
    const int code = cvol_search_run(&search, step, &plan, try_guess, &s);
    if (code)
        return code;
    if (search.has_ended_within) /* the next step misses by less, without another try */
        *step = cvol_search_next(&search);
    c->slope = slope_of(&search);
    return CVOL_OK;
}

/* Effort fast, PSNR target: a few cells give an approximate step; some bricks with that step give
 * the share of the error that samples show, and tables; more cells give the step. */
static int prepare_fast(cvol_compression *c, double *step)
{
    c->slope = 0.8;
    int code = guess_step(c, step, FEW_OF_CELLS, FAST_MISS);
    if (!code)
        code = cvol_attempt_measure_error_share(c->context, &c->attempt, *step);
    if (!code)
        code = cvol_attempt_fit(c->context, &c->attempt);
    return code ? code : guess_step(c, step, 1, GUESS_MISS);
}

int cvol_compression_prepare(cvol_compression *c, double *step)
{
    const int may_lap = c->attempt.shape->lapped;
    const double slope = c->target == CVOL_TARGET_PSNR ? 0.8 : 1.1;
    *step = first_step(c);
    c->attempt.lap_known = c->attempt.fast;
    if (c->target == CVOL_TARGET_PSNR && c->attempt.split == CVOL_SPLIT_FAST && c->attempt.samples)
        return prepare_fast(c, step);
    int code = sample_step(c, step, slope, 1);
    const double bits = 8 * (double)c->attempt.result.bytes; /* of the samples */
    if (!code && cvol_coding_of(c->attempt.shape)->trellis &&
        bits < TRELLIS_BITS_MIN * (double)c->attempt.inside) {
        cvol_file_coding *coding = cvol_coding_own(c->attempt.shape);
        coding->trellis = coding->neural = 0;
        *step = fmin(*step / TRELLIS_STEP_SHARE, c->most_step);
        code = sample_step(c, step, c->slope, 1);
    }
    if (!code && may_lap && !c->attempt.fast)
        code = cvol_attempt_choose_lap(c->context, &c->attempt, *step);
    if (!code && c->attempt.shape->lapped != may_lap)
        code = sample_step(c, step, c->slope, 1);
    if (!code && cvol_coding_of(c->attempt.shape)->neural) {
        code = cvol_attempt_choose_split_bias(c->context, &c->attempt, *step);
        /* Tables fitted to preferred sub-blocks would prefer them again. */
        if (!code)
            code = sample_step(c, step, c->slope, 0);
    }
    return code;
}

void cvol_compression_limits(cvol_compression *c)
{
    const cvol_array *shape = c->attempt.shape;
    const double span = shape->error_bound.value_max - shape->error_bound.value_min;
    /* No coefficient is larger: its basis function has L2 norm 1, and the pre-filter's norm is
     * CVOL_LAP_PRE_NORM_3. */
    const double largest = span * sqrt((double)cvol_array_block_terms(shape)) *
                           (shape->lapped ? CVOL_LAP_PRE_NORM_3 : 1);
    double least = span * 0x1p-23;
    if (cvol_type_is_integer(shape->grid.type)) {
        /* Errors of at most step / 2 in each of B^3 coefficients sum to less than 1/2. */
        const double exact = 0.99 / cvol_pow(shape->block, 1.5);
        least = least < exact ? exact : least;
    }
    if (least < largest * 0x1.01p-30)
        least = largest * 0x1.01p-30;
    c->least_step = least;
    c->most_step = fmax(2.01 * largest, 2 * least);
}
