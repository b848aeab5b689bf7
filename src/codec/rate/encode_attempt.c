/* Trials: the steps from samples to a measured array. */
#include "codec/rate/encode_attempt.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/core/summary.h"
#include "base/context.h"
#include "base/memory.h"
#include "codec/brick/brick_shape.h"
#include "codec/container/section_pack.h"
#include "codec/container/summary_section.h"
#include "codec/mask/mask_make.h"
#include "codec/mask/mask_section.h"
#include "codec/quantize/coding.h"
#include "codec/quantize/true_length.h"
#include "codec/rate/background.h"
#include "codec/rate/brick_choice.h"
#include "codec/rate/measure.h"
#include "transform/lap.h"

/* Of more, sums of squares and transforms would leave the range of float; and so would samples
 * themselves, even if they are all alike. */
#define SPAN_MOST 2e35
#define MAGNITUDE_MOST ((double)FLT_MAX)
/* More than so many of the bytes that are asked for leave nothing to speak of for all else. */
#define MASK_SHARE_MOST 0.9
/* Bytes of a brick's mask that are no tokens: what its cells are, its length and checksum. */
#define MASK_BRICK 16

/* All samples are there. */
static int fetch(cvol_context *context, void *user, cvol_slab *out, size_t first, size_t count)
{
    const cvol_trial *trial = user;
    (void)context;
    (void)first;
    (void)count;
    *out = (cvol_slab){trial->samples, 0, trial->shape->grid.dims[2]};
    return CVOL_OK;
}

/* Sections in front of the shells: headers and records, two bytes a brick and shell, a checksum a
 * run and shell (half of which may be empty where a brick is one), and the tables. */
static uint64_t front_estimate(const cvol_trial *trial, size_t table_bytes)
{
    const cvol_array *shape = trial->shape;
    const size_t run = cvol_coding_of(shape)->brick.run;
    const uint64_t a_brick = 2 * CVOL_SHELLS + (run > 1 ? 4 * CVOL_SHELLS / run : 2 * CVOL_SHELLS);
    const uint64_t summary = cvol_summary_section_bytes(cvol_array_summary(shape), &shape->ledger);
    if (trial->is_packed) /* the first brick's share is usual */
        return CVOL_PACK_USUAL_BYTES + a_brick * (uint64_t)(cvol_brick_count(shape) - 1) +
               table_bytes + (summary ? summary - CVOL_SECTION_HEADER_BYTES : 0);
    return 640 + a_brick * (uint64_t)cvol_brick_count(shape) + table_bytes + summary;
}

/* Whether the bytes that a target allows are within least .. most; a PSNR allows any. */
static int allows(const cvol_compress_options *options, const cvol_grid *grid, double least,
                  double most)
{
    const double value = options->target_value;
    if (options->target == CVOL_TARGET_PSNR)
        return 1;
    const double budget = options->target == CVOL_TARGET_BITS
                              ? (double)cvol_grid_samples(grid) * value / 8
                              : (double)cvol_grid_bytes(grid) / value;
    return least <= budget && budget <= most;
}

static int make_shape(cvol_context *context, cvol_trial *trial, const cvol_grid *grid,
                      const cvol_compress_options *options)
{
    const int block = options->block;
    int code = cvol_array_create(context, &trial->shape, grid, block);
    if (!code)
        code = cvol_coding_need(context, trial->shape);
    if (code)
        return code;
    cvol_file_coding *coding = cvol_coding_own(trial->shape);
    coding->brick = cvol_brick_shape_choose(grid, options);
    trial->is_packed = cvol_brick_count(trial->shape) <= coding->brick.run &&
                       allows(options, grid, 0, (double)CVOL_PACK_MOST);
    trial->shape->lapped = trial->may_lap = block == 16;
    coding->dependent = block == 16;
    for (int a = 0; a < 3 && block == 16; a++)
        if (grid->dims[a] % CVOL_CELL)
            trial->may_end = 1;
    trial->split = block == 16 ? CVOL_SPLIT_BEST : CVOL_SPLIT_NEVER;
    trial->error_share = 1;
    trial->tables = cvol_token_tables_create();
    trial->counts = cvol_allocate_zero(1, sizeof *trial->counts);
    if (!trial->tables || !trial->counts)
        return cvol_fail_memory(context, sizeof *trial->tables, "the coder's tables");
    return CVOL_OK;
}

/* The range of the samples decides about the offset. */
static int take_range(cvol_context *context, cvol_array *shape, double least, double most)
{
    shape->ledger.value_min = least;
    shape->ledger.value_max = most;
    shape->offset = least;
    if (!(most - least <= SPAN_MOST))
        return cvol_fail(context, CVOL_ERROR_DATA,
                         "samples reach from %g to %g, a range beyond %g cannot be compressed",
                         least, most, SPAN_MOST);
    if (!(fmax(-least, most) <= MAGNITUDE_MOST))
        return cvol_fail(context, CVOL_ERROR_DATA,
                         "samples reach from %g to %g, magnitudes beyond %g cannot be compressed",
                         least, most, MAGNITUDE_MOST);
    return CVOL_OK;
}

/* How the samples are distributed, for the file. */
static int summarise(cvol_context *context, cvol_trial *trial, const cvol_compress_options *options)
{
    cvol_array *shape = trial->shape;
    cvol_summary summary = {.state = CVOL_SUMMARY_LEFT_OUT};
    int code = CVOL_OK;
    if (!options->no_histogram)
        code = cvol_summarise_samples(context, &summary, trial->truth, &shape->grid, NULL);
    if (!code)
        code = cvol_array_set_summary(context, shape, &summary);
    trial->front_bytes = front_estimate(trial, 0);
    return code;
}

int cvol_trial_start(cvol_context *context, cvol_trial *trial, const void *samples,
                     const cvol_grid *grid, const cvol_compress_options *options)
{
    double least, most;
    *trial = (cvol_trial){.source = {fetch, trial, 1}, .samples = samples, .truth = samples};
    int code = make_shape(context, trial, grid, options);
    if (!code)
        code = cvol_survey_samples(context, &least, &most, samples, grid);
    if (!code)
        code = take_range(context, trial->shape, least, most);
    return code ? code : summarise(context, trial, options);
}

/* What a mask needs in a file: streams, their lengths and checksums. */
static int measure_mask(cvol_context *context, cvol_trial *trial)
{
    const int code = cvol_mask_measure(context, &trial->mask_bytes, trial->shape);
    trial->mask_bytes += MASK_BRICK * cvol_brick_count(trial->shape);
    trial->front_bytes += trial->mask_bytes;
    return code;
}

/* Whether a mask leaves some of the bytes that a target allows. */
static int can_pay(const cvol_compress_options *options, const cvol_grid *grid, uint64_t bytes)
{
    return allows(options, grid, (double)bytes / MASK_SHARE_MOST, (double)INFINITY);
}

static int start_masked(cvol_context *context, cvol_trial *trial, const void *samples,
                        const cvol_grid *grid, cvol_mask *mask, void *filled,
                        const cvol_compress_options *options)
{
    const double value = cvol_fills_value(cvol_mask_fills(mask), 0, grid->type);
    int code = cvol_trial_start(context, trial, filled, grid, options);
    trial->filled = filled;
    if (!trial->shape) {
        cvol_mask_free(mask);
        return code;
    }
    trial->truth = samples;
    trial->shape->mask = mask;
    if (!code) /* of all samples, instead of the filled ones */
        code = summarise(context, trial, options);
    const cvol_ledger *ledger = &trial->shape->ledger;
    if (!code)
        code = take_range(context, trial->shape, fmin(ledger->value_min, value),
                          fmax(ledger->value_max, value));
    if (!code)
        code = measure_mask(context, trial);
    if (code || options->background == CVOL_BACKGROUND_VALUE ||
        can_pay(options, grid, trial->mask_bytes))
        return code;
    cvol_trial_free(trial);
    return cvol_trial_start(context, trial, samples, grid, options);
}

int cvol_trial_start_with_background(cvol_context *context, cvol_trial *trial, const void *samples,
                                     const cvol_grid *grid, const cvol_compress_options *options)
{
    cvol_fills fills;
    double least_step;
    cvol_mask *mask = NULL;
    void *filled = NULL;
    int code = cvol_grid_check(context, grid, "array");
    if (!code)
        code = cvol_background_fills(context, &fills, &least_step, samples, grid, options);
    if (!code && fills.count)
        code = cvol_mask_make(context, &mask, &filled, samples, grid, &fills);
    if (code || !mask)
        return code ? code : cvol_trial_start(context, trial, samples, grid, options);
    code = start_masked(context, trial, samples, grid, mask, filled, options);
    trial->least_step = code || !trial->filled ? 0 : least_step;
    return code;
}

int cvol_trial_start_source(cvol_context *context, cvol_trial *trial,
                            const cvol_slab_source *source, const cvol_grid *grid,
                            const cvol_compress_options *options)
{
    double least = INFINITY, most = -INFINITY;
    *trial = (cvol_trial){.source = *source};
    int code = make_shape(context, trial, grid, options);
    if (!code && !options->no_histogram)
        code = cvol_tally_create(context, &trial->tally, grid, NULL);
    for (size_t first = 0; first < grid->dims[2] && !code; first += CVOL_BRICK_SIDE) {
        const size_t left = grid->dims[2] - first;
        cvol_grid part = *grid;
        cvol_slab slab;
        double from, to;
        part.dims[2] = left < CVOL_BRICK_SIDE ? left : CVOL_BRICK_SIDE;
        code = source->fetch(context, source->user, &slab, first, part.dims[2]);
        if (!code)
            code = cvol_survey_sheets(context, &from, &to, slab.samples, &part, first);
        if (!code && trial->tally)
            code = cvol_tally_add(context, trial->tally, slab.samples, cvol_grid_samples(&part));
        if (!code)
            code = cvol_report_progress(context, "looking through the samples",
                                        (double)first / (double)grid->dims[2]);
        if (!code) {
            least = fmin(least, from);
            most = fmax(most, to);
        }
    }
    if (!code)
        code = take_range(context, trial->shape, least, most);
    if (!code && !trial->tally)
        code = cvol_array_set_summary(context, trial->shape,
                                      &(cvol_summary){.state = CVOL_SUMMARY_LEFT_OUT});
    else if (!code && !cvol_tally_again(trial->tally))
        code = cvol_trial_end_tally(context, trial);
    trial->front_bytes = code ? 0 : front_estimate(trial, 0);
    return code;
}

int cvol_trial_end_tally(cvol_context *context, cvol_trial *trial)
{
    cvol_summary summary;
    cvol_tally_finish(trial->tally, &summary);
    cvol_tally_free(trial->tally);
    trial->tally = NULL;
    return cvol_array_set_summary(context, trial->shape, &summary);
}

void cvol_trial_set_options(cvol_trial *trial, const cvol_compress_options *options)
{
    cvol_file_coding *coding = cvol_coding_own(trial->shape);
    trial->hasty = options->fast;
    coding->small = options->smallest && coding->dependent;
    trial->coarse = coding->small ? (cvol_coarse_shares){1, 1} : (cvol_coarse_shares){0};
    trial->small_bytes = CVOL_SMALL_BYTES;
    trial->small_error = 1;
    if (options->no_lap)
        trial->shape->lapped = trial->may_lap = 0;
    if (options->fast && trial->split == CVOL_SPLIT_BEST)
        trial->split = CVOL_SPLIT_FAST;
    /* What corrections stand on is rounded for their sake. */
    if (options->fast || options->lossless || options->max_error > 0 ||
        options->target == CVOL_TARGET_MAX_ERROR)
        coding->dependent = coding->small = trial->may_end = 0;
}

/* Frees an array, but no mask that is the shape's. */
static void drop(const cvol_trial *trial, cvol_array **array)
{
    if (*array && (*array)->mask == trial->shape->mask)
        (*array)->mask = NULL;
    cvol_array_free(*array);
    *array = NULL;
}

cvol_array *cvol_trial_take_array(cvol_trial *trial)
{
    cvol_array *array = trial->array;
    if (array->mask == trial->shape->mask)
        trial->shape->mask = NULL;
    trial->array = NULL;
    return array;
}

void cvol_trial_free(cvol_trial *trial)
{
    drop(trial, &trial->array);
    drop(trial, &trial->kept);
    cvol_array_free(trial->shape);
    free(trial->filled);
    cvol_tally_free(trial->tally);
    cvol_coded_free(trial->coded);
    cvol_sampler_free(trial->sampler);
    cvol_cell_sample_free(trial->cells);
    free(trial->tables);
    free(trial->counts);
}

/* Of ends, terms in memory are finer than the step: not where they would become too large. */
void cvol_trial_set_step(cvol_trial *trial, double step)
{
    const cvol_array *shape = trial->shape;
    const double span = shape->ledger.value_max - shape->ledger.value_min;
    const double largest = 64 * CVOL_LAP_PRE_NORM_3 * span;
    trial->step = step;
    cvol_coding_own(trial->shape)->ends = trial->may_end &&
                                                  step > ldexp(largest, CVOL_ENDS_BITS - 29)
                                              ? CVOL_ENDS_BITS
                                              : 0;
}

int cvol_trial_pass(cvol_context *context, cvol_trial *trial, double step,
                    const cvol_brick_sink *sink, cvol_layer_hook *after, void *user)
{
    cvol_trial_set_step(trial, step);
    const double left = pow(0.5, trial->count++);
    const cvol_encode_pass pass = {.shape = trial->shape,
                                   .source = &trial->source,
                                   .tables = trial->tables,
                                   .weight = trial->weight,
                                   .options = {step, trial->split, trial->plain,
                                               cvol_coding_of(trial->shape)->dependent,
                                               trial->coarse},
                                   .sink = sink,
                                   .after = after,
                                   .user = user,
                                   .counts = trial->uncounted ? NULL : trial->counts,
                                   .kept = trial->kept,
                                   .progress_from = 0.9 * (1 - left),
                                   .progress_to = 0.9 * (1 - left / 2)};
    const int code = cvol_encode_pass_run(context, &trial->result, &pass);
    trial->bytes = trial->front_bytes + trial->result.bytes;
    trial->inside = cvol_grid_samples(&trial->shape->grid);
    return code;
}

/* An array like the shape, without terms yet. */
static int make_array(cvol_context *context, cvol_array **out, const cvol_trial *trial, double step)
{
    const cvol_array *shape = trial->shape;
    int code = cvol_array_create(context, out, &shape->grid, shape->block);
    if (!code)
        code = cvol_coding_copy(context, *out, shape);
    if (code)
        return code;
    (*out)->step = ldexp(step, -cvol_coding_of(shape)->ends);
    (*out)->offset = shape->offset;
    (*out)->lapped = shape->lapped;
    (*out)->mask = cvol_mask_is_background(shape->mask) ? shape->mask : NULL;
    (*out)->ledger.value_min = shape->ledger.value_min;
    (*out)->ledger.value_max = shape->ledger.value_max;
    return cvol_array_set_summary(context, *out, cvol_array_summary(shape));
}

int cvol_trial_encode(cvol_context *context, cvol_trial *trial, double step)
{
    cvol_coded_free(trial->coded);
    trial->coded = NULL;
    drop(trial, &trial->array); /* of another step */
    drop(trial, &trial->kept);
    cvol_trial_set_step(trial, step);
    int code = cvol_coded_make(context, &trial->coded, trial->tables, trial->shape);
    if (!code && trial->split == CVOL_SPLIT_FAST)
        code = make_array(context, &trial->kept, trial, step);
    if (code)
        return code;
    const cvol_brick_sink sink = cvol_coded_sink(trial->coded);
    return cvol_trial_pass(context, trial, step, &sink, NULL, NULL);
}

int cvol_trial_fit(cvol_context *context, cvol_trial *trial)
{
    cvol_bytes section = {0};
    cvol_token_tables_fit(trial->tables, trial->counts);
    const int code = cvol_token_tables_put(context, &section, trial->tables);
    trial->front_bytes = front_estimate(trial,
                                        cvol_coding_of(trial->shape)->small ? 0 : section.size) +
                         trial->mask_bytes;
    cvol_bytes_free(&section);
    return code;
}

double cvol_trial_psnr(const cvol_trial *trial)
{
    const double span = trial->shape->ledger.value_max - trial->shape->ledger.value_min;
    const double error = trial->result.error * trial->error_share / (double)trial->inside;
    return 10 * log10(span * span / error);
}

/* What is shown while a trial is decoded and measured: where its encoding has brought us. */
typedef struct standing {
    cvol_progress_fn progress;
    void *user;
    double fraction;
} standing;

static int tell_standing(void *user, const char *what, double fraction)
{
    const standing *at = user;
    (void)what;
    (void)fraction;
    return at->progress(at->user, "compressing", at->fraction);
}

static int decode(cvol_context *context, cvol_trial *trial)
{
    int code = CVOL_OK;
    if (trial->kept) {
        trial->array = trial->kept;
        trial->kept = NULL;
    } else {
        code = make_array(context, &trial->array, trial, trial->step);
        if (!code)
            code = cvol_coded_decode(context, trial->array, trial->coded);
    }
    if (code)
        return code;
    cvol_array *array = trial->array;
    cvol_distance distance;
    code = cvol_measure_distance(context, &distance, array, trial->truth);
    if (code)
        return code;
    cvol_array_set_measured(array, &distance);
    const double rounding = cvol_distance_rounding(array, &distance);
    array->ledger.l2_error = distance.real_l2_error + rounding;
    array->ledger.max_abs = distance.real_max_abs + rounding;
    return CVOL_OK;
}

int cvol_trial_decode(cvol_context *context, cvol_trial *trial)
{
    standing at = {context->progress, context->progress_user, 0.9 * (1 - pow(0.5, trial->count))};
    drop(trial, &trial->array);
    if (at.progress)
        cvol_context_set_progress(context, tell_standing, &at);
    const int code = decode(context, trial);
    cvol_context_set_progress(context, at.progress, at.user);
    return code;
}
