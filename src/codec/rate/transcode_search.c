/* The search for a step of requantization.
 *
 * Terms are multiples of the old step, so sizes jump where a step passes the value of many terms
 * (at twice the step, all terms of 1 vanish at once). Between the two steps of a jump, the search
 * takes the finer step and a larger weight of bits, so that the most expensive of those terms
 * vanish first. */
#include "codec/rate/transcode_search.h"

#include <math.h>
#include <string.h>

#include "array/core/array.h"
#include "array/core/summary.h"
#include "array/truncate/account.h"
#include "array/truncate/producer.h"
#include "base/context.h"
#include "base/elementary.h"
#include "codec/container/writer.h"
#include "codec/rate/step_search.h"

enum { TRIES_MAX = 16, FITTED_TRIES = 2, WEIGHTS_MAX = 14, FINER_MAX = 8 };
/* A narrower bracket of log steps contains a jump. */
#define JUMP_WIDTH 4e-3
#define WEIGHT_MAX 256
#define WEIGHT_WIDTH 1e-3
/* A smaller weight of bits has the effect of 0. */
#define LIGHTEST 1e-3
/* If weights do not help, a step finer by this factor may. */
#define FINER 0.94

/* Gives an array without terms all else that the source has, and this step. */
static int copy_properties(cvol_context *context, cvol_array *array, const cvol_array *from,
                           double step)
{
    int code = cvol_coding_copy(context, array, from);
    if (code)
        return code;
    array->step = ldexp(step, -cvol_coding_of(from)->true_length);
    array->offset = from->offset;
    array->lapped = from->lapped;
    array->threshold = from->threshold;
    array->error_bound = from->error_bound;
    code = cvol_array_set_summary(context, array, cvol_array_summary(from));
    if (!code && from->attributes)
        code = cvol_array_keep_attributes(context, array, from->attributes,
                                          strlen(from->attributes));
    return code;
}

int cvol_transcoding_make_like(cvol_context *context, cvol_array **out, const cvol_array *from,
                               double step)
{
    int code = cvol_array_create(context, out, &from->grid, from->block);
    if (!code)
        code = copy_properties(context, *out, from, step);
    if (code) {
        cvol_array_free(*out);
        *out = NULL;
    }
    return code;
}

void cvol_transcoding_account(const cvol_transcoding *t, cvol_array *array)
{
    const double distance = sqrt(fmax(t->error, 0));
    const double samples = (double)cvol_grid_samples(&array->grid);
    const double norm = (t->from->error_bound.max_abs + fabs(t->from->offset)) * sqrt(samples);
    const cvol_build_result result = {.dropped = distance * (1 + CVOL_ROUNDING),
                                      .norm = norm + distance,
                                      .max_abs = -1,
                                      .sample = distance};
    cvol_mask *own = array->mask;
    array->error_bound = t->from->error_bound;
    cvol_array_account(array, &result, 0);
    array->mask = t->from->mask; /* lent: tries have none, and missing samples do not count */
    cvol_array_derive_figures(array);
    array->mask = own;
}

double cvol_transcoding_own_step(const cvol_transcoding *t)
{
    return ldexp(t->from->step, cvol_coding_of(t->from)->true_length);
}

static int count_brick(cvol_context *context, void *user, size_t brick,
                       const cvol_span subbands[CVOL_SUBBANDS])
{
    (void)brick;
    return cvol_file_writer_add(context, user, subbands);
}

/* Codes with a step, and computes the file's size and bounds; keeps no bricks. */
static int try_step(cvol_transcoding *t, double step, double weight)
{
    const cvol_coarseness coarseness = {step, weight};
    cvol_file_writer *writer = NULL;
    cvol_array_free(t->shape);
    t->shape = NULL;
    t->count++;
    int code = cvol_transcoding_make_like(t->context, &t->shape, t->from, step);
    if (!code)
        code = cvol_file_writer_open(t->context, &writer, NULL, cvol_brick_count(t->from),
                                     cvol_coding_of(t->from)->brick.run);
    const cvol_brick_sink sink = {count_brick, writer};
    if (!code)
        code = cvol_requantise(t->context, &t->error, t->counts, t->from, coarseness, t->tables,
                               &sink);
    if (!code) {
        const cvol_header header = cvol_header_of(t->shape);
        const cvol_file_front front = {
            .header = &header, .attributes = t->shape->attributes, .tables = t->tables};
        code = cvol_file_writer_bytes(t->context, writer, &front, &t->file_bytes);
        t->file_bytes += t->other_bytes;
        cvol_transcoding_account(t, t->shape);
    }
    cvol_file_writer_abandon(writer);
    return code;
}

double cvol_transcoding_ratio(const cvol_transcoding *t)
{
    return (double)cvol_grid_bytes(&t->from->grid) / (double)t->file_bytes;
}

/* The miss of the last try, as in step_search.h. */
static double miss_of(const cvol_transcoding *t, int *kept, int *good)
{
    if (t->target == CVOL_TARGET_PSNR) {
        const double over = t->shape->psnr_db + t->slack_db - t->value;
        *kept = over >= 0;
        *good = over >= 0 && over < 2 * CVOL_PSNR_ACCEPTED;
        return (CVOL_PSNR_AIM - (over > 30 ? 30 : over)) / CVOL_DB_PER_E;
    }
    const double ratio = cvol_transcoding_ratio(t);
    *kept = ratio >= t->value;
    *good = ratio >= t->value && ratio <= t->value * CVOL_RATIO_ACCEPTED;
    return cvol_log(ratio / t->value / CVOL_RATIO_AIM);
}

static int fail_finer(const cvol_transcoding *t)
{
    if (t->target == CVOL_TARGET_PSNR)
        return cvol_fail(t->context, CVOL_ERROR_TARGET,
                         "a PSNR of %g dB cannot be promised: the array guarantees only %.2f "
                         "dB; compress the volume itself",
                         t->value, t->shape->psnr_db + t->slack_db);
    return cvol_fail(t->context, CVOL_ERROR_TARGET,
                     "a ratio of %g would be finer than the array, which is coded at %.2f already",
                     t->value, cvol_transcoding_ratio(t));
}

/* The best try that keeps the target, and its miss from the aim; step 0: none. */
typedef struct best_try {
    cvol_coarseness coarseness;
    double miss;
} best_try;

static void note(best_try *best, double step, double weight, double miss)
{
    if (best->coarseness.step <= 0 || fabs(miss) < best->miss)
        *best = (best_try){{step, weight}, fabs(miss)};
}

/* A search for a weight of bits at one step. */
typedef struct weight_search {
    cvol_transcoding *t;
    best_try *best;
    double step;
    int good;
} weight_search;

static int try_weight(void *user, int number, double weight, double *miss,
                      cvol_search_verdict *verdict)
{
    weight_search *search = user;
    (void)number;
    int kept;
    const int code = try_step(search->t, search->step, weight);
    if (code)
        return code;
    *miss = miss_of(search->t, &kept, &search->good);
    if (kept)
        note(search->best, search->step, weight, *miss);
    if (search->good)
        *verdict = CVOL_SEARCH_ENOUGH;
    return CVOL_OK;
}

/* At the finer step of a jump in size: searches for the weight of bits. */
static int search_weight(cvol_transcoding *t, best_try *best, double step, int *good)
{
    static const cvol_search_plan plan = {.attempts_max = WEIGHTS_MAX, .width = WEIGHT_WIDTH};
    weight_search weights = {t, best, step, 0};
    cvol_search search = cvol_search_make(1, WEIGHT_MAX, 0.3);
    double weight = 1.5;
    const int code = cvol_search_run(&search, &weight, &plan, try_weight, &weights);
    *good = weights.good;
    return code;
}

/* If the usual weight of bits at the source's own step gives a file smaller than the target,
 * searches for a weight from 0 on. At 0 all terms stay as they are, with tables fitted to them. */
static int search_own_step(cvol_transcoding *t, cvol_coarseness *out, int *reached)
{
    static const cvol_search_plan plan = {.attempts_max = WEIGHTS_MAX - 1, .width = WEIGHT_WIDTH};
    const double step = cvol_transcoding_own_step(t);
    best_try best = {{0, 1}, 0};
    weight_search weights = {t, &best, step, 0};
    cvol_search search = cvol_search_make(LIGHTEST, WEIGHT_MAX, 0.3);
    double weight = 1, miss = 0;
    cvol_search_verdict verdict = CVOL_SEARCH_GO_ON;
    int code = try_step(t, step, 0);
    if (code)
        return code;
    cvol_token_tables_fit(t->tables, t->counts);
    code = try_weight(&weights, 0, 0, &miss, &verdict);
    if (code)
        return code;
    if (best.coarseness.step > 0 && !weights.good) /* the target holds with all terms */
        return fail_finer(t);
    if (!weights.good) {
        cvol_search_report(&search, LIGHTEST, miss);
        code = cvol_search_run(&search, &weight, &plan, try_weight, &weights);
    }
    if (code)
        return code;
    *reached = best.coarseness.step > 0;
    *out = *reached ? best.coarseness : (cvol_coarseness){step, 1};
    return CVOL_OK;
}

/* The search for a step, up to the jump in sizes. */
typedef struct step_tries {
    cvol_transcoding *t;
    best_try best;
    int good;
    int is_finer; /* the target ratio is finer than the array at its own step */
} step_tries;

static int try_coarser(void *user, int number, double step, double *miss,
                       cvol_search_verdict *verdict)
{
    step_tries *tries = user;
    cvol_transcoding *t = tries->t;
    int kept;
    if (number >= 1 && number <= FITTED_TRIES)
        cvol_token_tables_fit(t->tables, t->counts);
    const int code = try_step(t, step, 1);
    if (code)
        return code;
    *miss = miss_of(t, &kept, &tries->good);
    /* At the finest step: a PSNR below the target fails; a ratio beyond it needs other weights. */
    if (number == 0 && t->target == CVOL_TARGET_PSNR && !kept)
        return fail_finer(t);
    tries->is_finer = number == 0 && t->target == CVOL_TARGET_RATIO && kept && !tries->good;
    if (number >= FITTED_TRIES && kept)
        note(&tries->best, step, 1, *miss);
    if (tries->is_finer || (tries->good && number >= FITTED_TRIES))
        *verdict = CVOL_SEARCH_ENOUGH;
    else if (number < FITTED_TRIES) /* results with other tables mislead */
        *verdict = CVOL_SEARCH_RESTART;
    return CVOL_OK;
}

int cvol_transcoding_search(cvol_transcoding *t, cvol_coarseness *out, int *reached)
{
    const double least = cvol_transcoding_own_step(t);
    const double most = fmax(2.01 * cvol_array_coefficient_bound(t->from), 2 * least);
    const double slope = t->target == CVOL_TARGET_PSNR ? 0.8 : 1.1;
    static const cvol_search_plan plan = {
        .attempts_max = TRIES_MAX, .unbounded = FITTED_TRIES, .width = JUMP_WIDTH};
    step_tries tries = {.t = t, .best = {{0, 1}, 0}};
    cvol_search search = cvol_search_make(least, most, slope);
    double step = least;
    int code = cvol_search_run(&search, &step, &plan, try_coarser, &tries);
    if (code)
        return code;
    if (tries.is_finer)
        return search_own_step(t, out, reached);
    const double finest = search.has_low && search.has_high ? cvol_exp(search.low) : 0;
    for (int i = 0; i < FINER_MAX && !tries.good && finest > 0; i++) {
        code = search_weight(t, &tries.best, fmax(finest * cvol_pow(FINER, i), least), &tries.good);
        if (code)
            return code;
    }
    *reached = tries.best.coarseness.step > 0;
    *out = tries.best.coarseness;
    if (!*reached)
        out->step = t->target == CVOL_TARGET_PSNR ? least : most;
    return CVOL_OK;
}
