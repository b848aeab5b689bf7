/* Makes a compressed volume coarser: searches for the step of requantization.
 *
 * Terms are multiples of the old step, so sizes jump where a step passes the value of many terms
 * (at twice the step, all terms of 1 vanish at once). Between the two steps of a jump, the search
 * takes the finer step and a larger weight of bits, so that the most expensive of those terms
 * vanish first. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/array.h"
#include "array/core/mask.h"
#include "array/core/share.h"
#include "array/core/summary.h"
#include "array/truncate/account.h"
#include "array/truncate/producer.h"
#include "base/context.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "codec/brick/brick_shape.h"
#include "codec/brick/coded.h"
#include "codec/container/array_file.h"
#include "codec/container/ranges.h"
#include "codec/container/writer.h"
#include "codec/quantize/coding.h"
#include "codec/rate/compress_options.h"
#include "codec/rate/requantize.h"
#include "codec/rate/step_search.h"
#include "codec/rate/volume_distance.h"
#include "cvol/codec.h"

enum { TRIES_MAX = 16, FITTED_TRIES = 2, WEIGHTS_MAX = 14, FINER_MAX = 8, COMMITS_MAX = 5 };
#define SLACK_MAX 30
/* A narrower bracket of log steps contains a jump. */
#define JUMP_WIDTH 4e-3
#define WEIGHT_MAX 256
#define WEIGHT_WIDTH 1e-3
/* A smaller weight of bits has the effect of 0. */
#define LIGHTEST 1e-3
/* If weights do not help, a step finer by this factor may. */
#define FINER 0.94

typedef struct transcoding {
    cvol_context *context;
    const cvol_array *from;
    cvol_target target;
    double value;
    cvol_token_tables *tables;
    cvol_token_counts *counts;
    cvol_array *shape; /* result of the last try, without terms */
    double error;      /* of the last try: squared */
    double slack_db;   /* known surplus of the measured PSNR over the tries' promise */
    double tried_db;   /* the tries' promise for the last committed step */
    uint64_t file_bytes, other_bytes;
    int count;
} transcoding;

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

/* Makes an array of the source's shape, without terms, with this step. */
static int make_like(cvol_context *context, cvol_array **out, const cvol_array *from, double step)
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

/* The result's bounds follow from the source's bounds and the distance of the coefficients; its
 * norm is at most the sum of the two norms. */
static void account(const transcoding *t, cvol_array *array)
{
    const double distance = sqrt(fmax(t->error, 0));
    const double samples = (double)cvol_grid_samples(&array->grid);
    const double norm = (t->from->error_bound.max_abs + fabs(t->from->offset)) * sqrt(samples);
    const cvol_build_result result = {.dropped = distance * (1 + CVOL_ROUNDING),
                                      .norm = norm + distance,
                                      .max_abs = -1,
                                      .sample = distance};
    array->error_bound = t->from->error_bound;
    cvol_array_account(array, &result, 0);
    cvol_array_derive_figures(array);
}

static double psnr_of(const cvol_array *array, double l2_error)
{
    const double span = array->error_bound.value_max - array->error_bound.value_min;
    return 20 * cvol_log10(span * sqrt((double)cvol_grid_samples(&array->grid)) / l2_error);
}

/* Tries bound the distance of coefficients. The distance of the two arrays' samples bounds more
 * tightly: the result's error is at most the source's error plus it (triangle inequality), as
 * floats for the error bound; and as stored samples, if the source's stored samples were measured,
 * without extra rounding. */
static int account_samples(const transcoding *t, cvol_array *array)
{
    const cvol_array *from = t->from;
    cvol_volume_distance apart;
    int code = cvol_volume_distance_between(t->context, &apart, from, array);
    if (code)
        return code;
    const double samples = sqrt((double)cvol_grid_samples(&array->grid));
    const double norm = (from->error_bound.max_abs + fabs(from->offset)) * samples + apart.real_l2;
    const double l2_error = from->error_bound.l2_error + apart.real_l2 + CVOL_ROUNDING * norm;
    const double point = cvol_error_bound_point(&from->error_bound) + apart.real_most +
                         cvol_array_sample_rounding(array);
    array->error_bound.point_error = fmin(cvol_error_bound_point(&array->error_bound), point);
    array->error_bound.l2_error = fmin(array->error_bound.l2_error, l2_error);
    cvol_array_derive_figures(array);
    if (!from->measured || cvol_mask_is_void(from->mask)) /* a PSNR of fewer samples */
        return CVOL_OK;
    const double span = from->error_bound.value_max - from->error_bound.value_min;
    const double off = span * samples * cvol_pow(10, -from->psnr_db / 20) * (1 + 1e-9);
    array->max_error = fmin(array->max_error, (from->max_error + apart.most) * (1 + 1e-9));
    array->psnr_db = fmax(array->psnr_db, psnr_of(array, off + apart.stored_l2));
    return CVOL_OK;
}

static int count_brick(cvol_context *context, void *user, size_t brick,
                       const cvol_span subbands[CVOL_SUBBANDS])
{
    (void)brick;
    return cvol_file_writer_add(context, user, subbands);
}

/* Codes with a step, and computes the file's size and bounds; keeps no bricks. */
static int try_step(transcoding *t, double step, double weight)
{
    const cvol_coarseness coarseness = {step, weight};
    cvol_file_writer *writer = NULL;
    cvol_array_free(t->shape);
    t->shape = NULL;
    t->count++;
    int code = make_like(t->context, &t->shape, t->from, step);
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
        account(t, t->shape);
    }
    cvol_file_writer_abandon(writer);
    return code;
}

static double ratio_of(const transcoding *t)
{
    return (double)cvol_grid_bytes(&t->from->grid) / (double)t->file_bytes;
}

/* The miss of the last try, as in step_search.h. */
static double miss_of(const transcoding *t, int *kept, int *good)
{
    if (t->target == CVOL_TARGET_PSNR) {
        const double over = t->shape->psnr_db + t->slack_db - t->value;
        *kept = over >= 0;
        *good = over >= 0 && over < 2 * CVOL_PSNR_ACCEPTED;
        return (CVOL_PSNR_AIM - (over > 30 ? 30 : over)) / CVOL_DB_PER_E;
    }
    const double ratio = ratio_of(t);
    *kept = ratio >= t->value;
    *good = ratio >= t->value && ratio <= t->value * CVOL_RATIO_ACCEPTED;
    return cvol_log(ratio / t->value / CVOL_RATIO_AIM);
}

static int fail_finer(const transcoding *t)
{
    if (t->target == CVOL_TARGET_PSNR)
        return cvol_fail(t->context, CVOL_ERROR_TARGET,
                         "a PSNR of %g dB cannot be promised: the array guarantees only %.2f "
                         "dB; compress the volume itself",
                         t->value, t->shape->psnr_db + t->slack_db);
    return cvol_fail(t->context, CVOL_ERROR_TARGET,
                     "a ratio of %g would be finer than the array, which is coded at %.2f already",
                     t->value, ratio_of(t));
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
    transcoding *t;
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
static int search_weight(transcoding *t, best_try *best, double step, int *good)
{
    static const cvol_search_plan plan = {.attempts_max = WEIGHTS_MAX, .width = WEIGHT_WIDTH};
    weight_search weights = {t, best, step, 0};
    cvol_search search = cvol_search_make(1, WEIGHT_MAX, 0.3);
    double weight = 1.5;
    const int code = cvol_search_run(&search, &weight, &plan, try_weight, &weights);
    *good = weights.good;
    return code;
}

/* The step of the source's encoding. */
static double own_step(const transcoding *t)
{
    return ldexp(t->from->step, cvol_coding_of(t->from)->true_length);
}

/* If the usual weight of bits at the source's own step gives a file smaller than the target,
 * searches for a weight from 0 on. At 0 all terms stay as they are, with tables fitted to them. */
static int search_own_step(transcoding *t, cvol_coarseness *out, int *reached)
{
    static const cvol_search_plan plan = {.attempts_max = WEIGHTS_MAX - 1, .width = WEIGHT_WIDTH};
    const double step = own_step(t);
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
    transcoding *t;
    best_try best;
    int good;
    int is_finer; /* the target ratio is finer than the array at its own step */
} step_tries;

static int try_coarser(void *user, int number, double step, double *miss,
                       cvol_search_verdict *verdict)
{
    step_tries *tries = user;
    transcoding *t = tries->t;
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

/* Finds the coarsest step that keeps a PSNR, or the finest that keeps a ratio; *met is 0 if no step
 * does. */
static int search_step(transcoding *t, cvol_coarseness *out, int *reached)
{
    const double least = own_step(t);
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

/* Copies the source's mask, cell by cell. */
static int copy_mask(cvol_context *context, cvol_array *to, const cvol_array *from)
{
    uint8_t which[CVOL_MASK_CELL * CVOL_MASK_CELL * CVOL_MASK_CELL];
    const size_t *dims = from->grid.dims;
    if (!from->mask)
        return CVOL_OK;
    int code = cvol_mask_create(context, &to->mask, dims, cvol_mask_fills(from->mask));
    for (size_t z = 0; z < dims[2] && !code; z += CVOL_MASK_CELL)
        for (size_t y = 0; y < dims[1] && !code; y += CVOL_MASK_CELL)
            for (size_t x = 0; x < dims[0] && !code; x += CVOL_MASK_CELL) {
                const size_t begin[3] = {x, y, z};
                size_t end[3];
                for (int a = 0; a < 3; a++)
                    end[a] = dims[a] - begin[a] < CVOL_MASK_CELL ? dims[a]
                                                                 : begin[a] + CVOL_MASK_CELL;
                if (cvol_mask_get(which, from->mask, begin, end) &&
                    !cvol_mask_set(to->mask, which, begin, end))
                    code = cvol_fail_memory(context, sizeof which, "the mask");
            }
    return code;
}

/* A process of a team decodes the bricks of its share and around it. */
static int decode(cvol_context *context, cvol_array *array, const cvol_coded *coded)
{
    const cvol_share share = cvol_share_of(context, array);
    const size_t around = (size_t)array->block, *dims = array->grid.dims;
    if (!share.team)
        return cvol_coded_decode(context, array, coded, NULL);
    cvol_box box = {.end = {dims[0], dims[1], dims[2]}};
    if (share.slices[0] > around)
        box.begin[2] = share.slices[0] - around;
    if (share.slices[1] + around < dims[2])
        box.end[2] = share.slices[1] + around;
    const int code = cvol_coded_decode(context, array, coded, &box);
    return code ? code : cvol_share_count_terms(context, &array->coefficients, array);
}

/* Makes the array of a step, with its coded bricks. */
static int commit_step(transcoding *t, cvol_array **out, cvol_coarseness coarseness)
{
    cvol_coded *coded = NULL;
    int code = cvol_coded_make(t->context, &coded, t->tables, t->from);
    const cvol_brick_sink sink = cvol_coded_sink(coded);
    if (!code)
        code = cvol_requantise(t->context, &t->error, t->counts, t->from, coarseness, t->tables,
                               &sink);
    if (!code)
        code = make_like(t->context, out, t->from, coarseness.step);
    if (!code)
        code = decode(t->context, *out, coded);
    if (!code)
        code = copy_mask(t->context, *out, t->from);
    if (!code) {
        account(t, *out);
        t->tried_db = (*out)->psnr_db;
        code = account_samples(t, *out);
    }
    if (!code && cvol_array_may_have_ranges(*out, t->file_bytes))
        code = cvol_ranges_find(t->context, *out);
    if (!code) {
        cvol_coded_attach(*out, coded);
        coded = NULL;
        code = cvol_array_file_bytes(t->context, *out, &t->file_bytes);
    }
    cvol_coded_free(coded);
    return code;
}

/* The bytes of ranges and masks are known only at the end: further searches include them. */
static int run_ratio(transcoding *t, cvol_array **out, int *reached)
{
    for (int i = 0; i < COMMITS_MAX; i++) {
        cvol_coarseness best;
        int code = search_step(t, &best, reached);
        if (code)
            return code;
        const uint64_t counted = t->file_bytes;
        cvol_array_free(*out);
        *out = NULL;
        code = commit_step(t, out, best);
        if (code || ratio_of(t) >= t->value || !*reached)
            return code;
        t->other_bytes += t->file_bytes > counted ? t->file_bytes - counted : 0;
    }
    *reached = 0;
    return CVOL_OK;
}

/* The measured PSNR of a step is known only after it is committed; later searches may then lower
 * the target by that surplus. The result of the estimates alone is kept as a fallback. */
static int run_psnr(transcoding *t, cvol_array **out, int *reached)
{
    int code = CVOL_OK;
    if (t->from->measured && t->from->psnr_db > t->value) {
        cvol_array *finest;
        code = make_like(t->context, &finest, t->from, own_step(t));
        if (code)
            return code;
        t->error = 0;
        account(t, finest);
        t->slack_db = fmin(t->from->psnr_db - finest->psnr_db, SLACK_MAX);
        cvol_array_free(finest);
    }
    for (int i = 0; i < COMMITS_MAX; i++) {
        cvol_coarseness best;
        if (i == COMMITS_MAX - 1)
            t->slack_db = 0;
        code = search_step(t, &best, reached);
        if (!code) {
            cvol_array_free(*out);
            *out = NULL;
            code = commit_step(t, out, best);
        }
        if (code)
            return code;
        const double over = (*out)->psnr_db - t->value;
        if (over >= 0 && (over < 2 * CVOL_PSNR_ACCEPTED || i >= COMMITS_MAX - 2))
            break;
        t->slack_db = fmax((*out)->psnr_db - t->tried_db, 0);
    }
    return CVOL_OK;
}

static int run(transcoding *t, cvol_array **out, int *reached)
{
    return t->target == CVOL_TARGET_PSNR ? run_psnr(t, out, reached) : run_ratio(t, out, reached);
}

static int check(cvol_context *context, transcoding *t, const cvol_compress_options *options)
{
    int code = cvol_compress_options_check(context, options);
    if (!code)
        code = cvol_array_need_volume(context, t->from, "transcoding");
    if (!code && options->target == CVOL_TARGET_MAX_ERROR)
        code = cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "transcoding cannot keep a maximum error: it has no original samples; "
                         "compress the volume itself");
    t->target = options->target;
    t->value = options->target_value;
    if (!code && t->target == CVOL_TARGET_BITS) {
        t->target = CVOL_TARGET_RATIO;
        code = cvol_ratio_of_bits(context, &t->value, options->target_value, t->from->grid.type);
    }
    return code;
}

/* ---- arrays with a residual ------------------------------------------------------------ */

/* The root mean square error that a PSNR means. */
static double rms_of(double span, double psnr_db)
{
    return isfinite(psnr_db) ? span * cvol_pow(10, -psnr_db / 20) : 0;
}

static double span_of(const cvol_array *array)
{
    return array->error_bound.value_max - array->error_bound.value_min;
}

/* A PSNR of the decoded samples that leaves room for the source's own error. Their range is not
 * wider than that of the original ones. */
static int choose_psnr(cvol_context *context, cvol_compress_options *how, const cvol_array *array)
{
    const double span = span_of(array), own = rms_of(span, array->psnr_db);
    const double room = rms_of(span, how->target_value) - own;
    if (how->target != CVOL_TARGET_PSNR || !(own > 0))
        return CVOL_OK;
    if (!(room > 0))
        return cvol_fail(context, CVOL_ERROR_TARGET,
                         "a PSNR of %g dB cannot be promised: the array guarantees only %.2f dB; "
                         "compress the volume itself",
                         how->target_value, array->psnr_db);
    how->target_value = 20 * cvol_log10(span / room);
    return CVOL_OK;
}

/* Adds the source's own errors to the bounds of an array of its decoded samples. */
static void add_errors(cvol_array *out, const cvol_array *array)
{
    const double each = array->max_error,
                 all = each * sqrt((double)cvol_grid_samples(&array->grid)),
                 rms = rms_of(span_of(array), array->psnr_db) + rms_of(span_of(out), out->psnr_db);
    cvol_error_bound_widen(&out->error_bound, all, each);
    out->max_error += each;
    out->measured = 0;
    out->psnr_db = rms > 0 ? 20 * cvol_log10(span_of(array) / rms)
                           : fmin(out->psnr_db, array->psnr_db);
}

static int compress_samples(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                            const cvol_array *array, const void *samples,
                            const cvol_compress_options *how)
{
    int code = cvol_compress(context, out, report, samples, &array->grid, how);
    if (!code && array->attributes)
        code = cvol_array_keep_attributes(context, *out, array->attributes,
                                          strlen(array->attributes));
    if (!code && array->max_error > 0)
        add_errors(*out, array);
    return code;
}

/* Its terms are coarser than its decoded samples, so the decoded samples are compressed. The
 * source's own errors are added to the bound; for them, and for attributes, the file has more bytes
 * than the compression counts: a second one includes these. */
static int compress_decoded(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                            const transcoding *t, const cvol_compress_options *options)
{
    const cvol_array *array = t->from;
    const size_t zero[3] = {0, 0, 0};
    const cvol_fills *fills = cvol_mask_is_void(array->mask) ? cvol_mask_fills(array->mask) : NULL;
    const double raw = (double)cvol_grid_bytes(&array->grid);
    cvol_compress_options how = *options;
    cvol_compress_report found = {0};
    uint64_t bytes = 0;
    void *samples = cvol_allocate(cvol_grid_samples(&array->grid),
                                  cvol_type_size(array->grid.type));
    if (!samples)
        return cvol_fail_memory(context, cvol_grid_bytes(&array->grid), "the decoded samples");
    how.target = t->target;
    how.target_value = t->value;
    how.least_psnr = 0;
    how.has_fill = fills != NULL; /* one finite value at most; all NaN and infinite ones */
    for (int i = 0; fills && i < fills->count; i++) {
        const double value = cvol_fills_value(fills, i, array->grid.type);
        how.fill = i == 0 || isfinite(value) ? value : how.fill;
    }
    int code = cvol_array_evaluate_box(context, samples, array, zero, array->grid.dims);
    if (!code)
        code = choose_psnr(context, &how, array);
    for (int i = 0; i < 2 && !code; i++) {
        cvol_array_free(*out);
        *out = NULL;
        code = compress_samples(context, out, &found, array, samples, &how);
        if (!code)
            code = cvol_array_file_bytes(context, *out, &bytes);
        const double most = raw / t->value - ((double)bytes - (double)found.file_bytes);
        if (t->target != CVOL_TARGET_RATIO || (double)bytes * t->value <= raw || !(most > 0))
            break;
        how.target_value = raw / most;
    }
    free(samples);
    if (code) {
        cvol_array_free(*out);
        *out = NULL;
    } else if (report) {
        *report = found;
        report->file_bytes = bytes;
        report->ratio = raw / (double)bytes;
        report->psnr_db = (*out)->psnr_db;
        report->max_error = (*out)->max_error;
        report->lossless = found.lossless && !(array->max_error > 0);
        report->target_met = found.target_met &&
                             (t->target != CVOL_TARGET_RATIO || report->ratio >= t->value);
    }
    return code;
}

static int transcode(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                     const cvol_array *array, const cvol_compress_options *options)
{
    cvol_array from = *array; /* but without its bricks and its summary */
    cvol_file_coding coding = *cvol_coding_of(array);
    cvol_summary summary = *cvol_array_summary(array);
    transcoding t = {.context = context, .from = &from};
    int reached = 0;
    *out = NULL;
    int code = check(context, &t, options);
    if (!code)
        code = cvol_brick_sides_check(context, options->brick, array->block);
    if (!code && array->residual)
        return compress_decoded(context, out, report, &t, options);
    if (!code && options->brick[0])
        coding.brick = cvol_brick_shape_make(options->brick);
    from.coding = &coding.base;
    if (!code && options->no_histogram)
        summary.state = CVOL_SUMMARY_LEFT_OUT;
    else if (!code && summary.state != CVOL_SUMMARY_LEFT_OUT)
        code = cvol_summarise_array(context, &summary, array);
    from.summary = &summary;
    if (code)
        return code;
    t.tables = cvol_token_tables_create();
    t.counts = cvol_allocate_zero(1, sizeof *t.counts);
    code = t.tables && t.counts ? run(&t, out, &reached)
                                : cvol_fail_memory(context, sizeof *t.counts, "the coder's tables");
    if (code) {
        cvol_array_free(*out);
        *out = NULL;
    } else if (report) {
        *report = (cvol_compress_report){.ratio = ratio_of(&t),
                                         .psnr_db = (*out)->psnr_db,
                                         .max_error = (*out)->max_error,
                                         .file_bytes = t.file_bytes,
                                         .target_met = reached,
                                         .trials = t.count,
                                         .coefficients = (*out)->coefficients};
    }
    cvol_array_free(t.shape);
    free(t.tables);
    free(t.counts);
    return code;
}

int cvol_array_transcode(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                         const cvol_array *array, const cvol_compress_options *options)
{
    cvol_compress_options full;
    *out = NULL;
    int code = cvol_compress_options_complete(context, &full, options);
    if (!code)
        code = transcode(context, out, report, array, &full);
    if (code)
        return code;
    const double psnr_db = (*out)->psnr_db;
    code = cvol_compress_check_least_psnr(context, &full, psnr_db, !(*out)->measured);
    if (code) {
        cvol_array_free(*out);
        *out = NULL;
        if (report)
            report->psnr_db = psnr_db;
    }
    return code;
}
